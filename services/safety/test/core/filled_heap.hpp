// What fresh memory holds before anybody writes to it.
#pragma once

namespace fairlead::test {

/// The byte that test_allocations.cpp's allocator fills new memory with; -1: leaves it as it is.
inline int heap_fill = -1;

/// While it lives, new memory holds nothing but `fill`.
struct FilledHeap {
  explicit FilledHeap(int fill) { heap_fill = fill; }
  ~FilledHeap() { heap_fill = -1; }
  FilledHeap(const FilledHeap&) = delete;
  FilledHeap& operator=(const FilledHeap&) = delete;
};

}  // namespace fairlead::test
