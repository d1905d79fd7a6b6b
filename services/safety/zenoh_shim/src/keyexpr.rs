//! Key expressions as views on the caller's text, and text as a view on a key.

use std::ffi::{c_char, CStr};
use std::mem::{align_of, size_of};
use std::{ptr, str};

use zenoh::key_expr::{keyexpr, KeyExpr};

use crate::boundary::{guard, guard_void, ZResultCode, NULL, PARSE};

/// In place, because a view has no drop: a box would leak.
#[repr(C, align(8))]
pub struct ViewKeyExpr {
    storage: [u64; 6],
}

const _: () = assert!(size_of::<KeyExpr>() <= size_of::<ViewKeyExpr>());
const _: () = assert!(align_of::<KeyExpr>() <= align_of::<ViewKeyExpr>());

/// Text that is not NUL-terminated; valid as long as what it looks at.
#[repr(C)]
pub struct ViewString {
    data: *const c_char,
    len: usize,
}

/// The key to declare or reply on, copied so that the caller's text may go.
///
/// # Safety
/// `key` is null or a loaned key expression.
pub unsafe fn owned(key: *const KeyExpr<'static>) -> Result<KeyExpr<'static>, ZResultCode> {
    let key = key.as_ref().ok_or(NULL)?;
    if key.is_dummy() {
        return Err(PARSE);
    }
    KeyExpr::try_from(key.as_str().to_owned()).map_err(|_| PARSE)
}

#[no_mangle]
pub unsafe extern "C" fn z_view_keyexpr_from_str(
    this: *mut ViewKeyExpr,
    text: *const c_char,
) -> ZResultCode {
    guard(|| {
        if this.is_null() {
            return Err(NULL);
        }
        ptr::write(this.cast(), KeyExpr::dummy());
        if text.is_null() {
            return Err(NULL);
        }
        let text: &'static str = CStr::from_ptr(text).to_str().map_err(|_| PARSE)?;
        let key: &'static keyexpr = keyexpr::new(text).map_err(|_| PARSE)?;
        ptr::write(this.cast(), KeyExpr::from(key));
        Ok(())
    })
}

#[no_mangle]
pub unsafe extern "C" fn z_view_keyexpr_loan(this: *const ViewKeyExpr) -> *const KeyExpr<'static> {
    this.cast()
}

#[no_mangle]
pub unsafe extern "C" fn z_keyexpr_as_view_string(
    this: *const KeyExpr<'static>,
    out: *mut ViewString,
) {
    guard_void(|| {
        if out.is_null() {
            return;
        }
        let text = this.as_ref().map_or("", |key| key.as_str());
        ptr::write(
            out,
            ViewString {
                data: text.as_ptr().cast(),
                len: text.len(),
            },
        );
    });
}

#[no_mangle]
pub unsafe extern "C" fn z_view_string_loan(this: *const ViewString) -> *const ViewString {
    this
}

#[no_mangle]
pub unsafe extern "C" fn z_string_data(this: *const ViewString) -> *const c_char {
    this.as_ref().map_or(ptr::null(), |view| view.data)
}

#[no_mangle]
pub unsafe extern "C" fn z_string_len(this: *const ViewString) -> usize {
    this.as_ref().map_or(0, |view| view.len)
}
