//! What crosses the language boundary: result codes, panics stopped, owned pointers.

use std::panic::{catch_unwind, AssertUnwindSafe};
use std::ptr;

/// `z_result_t`: 0 is success, everything below is an error.
pub type ZResultCode = i8;

pub const OK: ZResultCode = 0;
pub const INVALID: ZResultCode = -1;
pub const PARSE: ZResultCode = -2;
pub const NETWORK: ZResultCode = -4;
pub const NULL: ZResultCode = -5;
pub const GENERIC: ZResultCode = i8::MIN;

/// Runs a fallible body; an error or a panic becomes its code.
pub fn guard(body: impl FnOnce() -> Result<(), ZResultCode>) -> ZResultCode {
    match catch_unwind(AssertUnwindSafe(body)) {
        Ok(Ok(())) => OK,
        Ok(Err(code)) => code,
        Err(_) => GENERIC,
    }
}

/// Runs a body that has nothing to report; a panic ends it quietly (the hook has printed it).
pub fn guard_void(body: impl FnOnce()) {
    let _ = catch_unwind(AssertUnwindSafe(body));
}

/// The layout of every boxed `z_owned_X_t` and, through a cast, of its `z_moved_X_t`.
#[repr(C)]
pub struct Owned<T> {
    value: *mut T,
}

/// Writes a dropped value, so that a failed call leaves something safe to drop.
///
/// # Safety
/// `this` is null or points to writable memory for one owned value.
pub unsafe fn clear<T>(this: *mut Owned<T>) -> Result<(), ZResultCode> {
    if this.is_null() {
        return Err(NULL);
    }
    ptr::write(
        this,
        Owned {
            value: ptr::null_mut(),
        },
    );
    Ok(())
}

/// Stores a value in an owned place that holds none.
///
/// # Safety
/// As `clear`.
pub unsafe fn store<T>(this: *mut Owned<T>, value: T) {
    (*this).value = Box::into_raw(Box::new(value));
}

/// Takes the value out and leaves the place dropped; `None` if it was.
///
/// # Safety
/// `this` is null or points to an owned value that `clear` or `store` has written.
pub unsafe fn take<T>(this: *mut Owned<T>) -> Option<T> {
    let owned = this.as_mut()?;
    let value = std::mem::replace(&mut owned.value, ptr::null_mut());
    (!value.is_null()).then(|| *Box::from_raw(value))
}

/// The loaned pointer of an owned value, null if dropped.
///
/// # Safety
/// As `take`.
pub unsafe fn loan<T>(this: *const Owned<T>) -> *const T {
    this.as_ref().map_or(ptr::null(), |owned| owned.value)
}

/// Refuses options whose layout this library does not know.
pub fn no_options<T>(options: *const T) -> Result<(), ZResultCode> {
    if options.is_null() {
        Ok(())
    } else {
        Err(INVALID)
    }
}
