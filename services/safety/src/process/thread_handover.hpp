// For ThreadSanitizer, which cannot see into Zenoh's library: what a thread has made before it
// declared a callback is there when Zenoh's threads run that. Nothing in any other build.
#pragma once

#if defined(__SANITIZE_THREAD__)
#include <sanitizer/tsan_interface.h>
#endif

namespace fairlead {

/// Called before a callback with this context is declared.
inline void hand_over([[maybe_unused]] void* context) {
#if defined(__SANITIZE_THREAD__)
  __tsan_release(context);
#endif
}

/// Called first in the callback.
inline void take_over([[maybe_unused]] void* context) {
#if defined(__SANITIZE_THREAD__)
  __tsan_acquire(context);
#endif
}

}  // namespace fairlead
