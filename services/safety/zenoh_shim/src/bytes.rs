//! Payloads: copied in when sent, copied out by a reader when received.

use std::mem::{align_of, size_of};
use std::{ptr, slice};

use zenoh::bytes::ZBytes;

use crate::boundary::{guard, guard_void, ZResultCode, NULL};

/// In place: an empty payload needs no allocation, so it stands for "dropped".
#[repr(C, align(8))]
pub struct OwnedBytes {
    storage: [u64; 8],
}

const _: () = assert!(size_of::<ZBytes>() <= size_of::<OwnedBytes>());
const _: () = assert!(align_of::<ZBytes>() <= align_of::<OwnedBytes>());

/// Takes the payload out, leaving an empty one.
///
/// # Safety
/// `this` is null or points to an initialised owned payload.
pub unsafe fn take(this: *mut OwnedBytes) -> Result<ZBytes, ZResultCode> {
    let bytes = this.cast::<ZBytes>().as_mut().ok_or(NULL)?;
    Ok(std::mem::take(bytes))
}

#[no_mangle]
pub unsafe extern "C" fn z_bytes_copy_from_buf(
    this: *mut OwnedBytes,
    data: *const u8,
    len: usize,
) -> ZResultCode {
    guard(|| {
        if this.is_null() {
            return Err(NULL);
        }
        ptr::write(this.cast(), ZBytes::default());
        if data.is_null() && len > 0 {
            return Err(NULL);
        }
        if len > 0 {
            *this.cast() = ZBytes::from(slice::from_raw_parts(data, len));
        }
        Ok(())
    })
}

#[no_mangle]
pub unsafe extern "C" fn z_bytes_drop(this: *mut OwnedBytes) {
    guard_void(|| drop(take(this)));
}

#[no_mangle]
pub unsafe extern "C" fn z_bytes_loan(this: *const OwnedBytes) -> *const ZBytes {
    this.cast()
}

#[no_mangle]
pub unsafe extern "C" fn z_bytes_len(this: *const ZBytes) -> usize {
    this.as_ref().map_or(0, ZBytes::len)
}

/// A position in a loaned payload; valid as long as the payload is.
#[repr(C)]
pub struct BytesReader {
    bytes: *const ZBytes,
    position: usize,
}

#[no_mangle]
pub unsafe extern "C" fn z_bytes_get_reader(this: *const ZBytes) -> BytesReader {
    BytesReader {
        bytes: this,
        position: 0,
    }
}

/// Copies up to `len` bytes across the payload's slices; returns how many.
#[no_mangle]
pub unsafe extern "C" fn z_bytes_reader_read(
    this: *mut BytesReader,
    dst: *mut u8,
    len: usize,
) -> usize {
    let mut copied = 0;
    guard_void(|| {
        let Some(reader) = this.as_mut() else { return };
        let Some(bytes) = reader.bytes.as_ref() else {
            return;
        };
        let mut skip = reader.position;
        for part in bytes.slices() {
            let skipped = skip.min(part.len());
            skip -= skipped;
            let part = &part[skipped..];
            let count = part.len().min(len - copied);
            ptr::copy_nonoverlapping(part.as_ptr(), dst.add(copied), count);
            copied += count;
        }
        reader.position += copied;
    });
    copied
}
