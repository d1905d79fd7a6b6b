//! A C callback with its context, as Zenoh may call it from any thread.

use std::ffi::c_void;
use std::{mem, ptr};

use crate::boundary::{ZResultCode, NULL};

type Call<T> = unsafe extern "C" fn(*mut T, *mut c_void);
type Drop = unsafe extern "C" fn(*mut c_void);

/// The layout of `z_owned_closure_X_t`; `call` is null once moved out.
#[repr(C)]
pub struct OwnedClosure<T> {
    context: *mut c_void,
    call: Option<Call<T>>,
    drop: Option<Drop>,
}

/// A closure handed to Zenoh; its context is released when Zenoh lets go of it.
pub struct Callback<T>(OwnedClosure<T>);

// The C side promises that its callback and context may be used from several threads.
unsafe impl<T> Send for Callback<T> {}
unsafe impl<T> Sync for Callback<T> {}

impl<T> Callback<T> {
    pub fn run(&self, mut value: T) {
        if let Some(call) = self.0.call {
            unsafe { call(&mut value, self.0.context) };
        }
    }
}

impl<T> std::ops::Drop for Callback<T> {
    fn drop(&mut self) {
        if let Some(drop) = self.0.drop {
            unsafe { drop(self.0.context) };
        }
    }
}

impl<T> OwnedClosure<T> {
    /// Fills a place the caller has reserved.
    ///
    /// # Safety
    /// `this` is null or points to writable memory for one closure.
    pub unsafe fn write(
        this: *mut Self,
        call: Option<Call<T>>,
        drop: Option<Drop>,
        context: *mut c_void,
    ) {
        if !this.is_null() {
            ptr::write(
                this,
                OwnedClosure {
                    context,
                    call,
                    drop,
                },
            );
        }
    }

    /// Moves the closure out of its place.
    ///
    /// # Safety
    /// `this` is null or points to a closure that `write` has filled.
    pub unsafe fn take(this: *mut Self) -> Result<Callback<T>, ZResultCode> {
        let empty = OwnedClosure {
            context: ptr::null_mut(),
            call: None,
            drop: None,
        };
        let closure = mem::replace(this.as_mut().ok_or(NULL)?, empty);
        if closure.call.is_none() {
            return Err(NULL);
        }
        Ok(Callback(closure))
    }
}
