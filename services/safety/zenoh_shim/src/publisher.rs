//! Declared publishers and the encoding they announce.

use std::ffi::{c_char, c_void, CStr};
use std::ptr;

use zenoh::bytes::Encoding;
use zenoh::key_expr::KeyExpr;
use zenoh::pubsub::Publisher;
use zenoh::qos::{CongestionControl, Priority};
use zenoh::{Session, Wait};

use crate::boundary::{
    clear, guard, guard_void, loan, no_options, store, take, Owned, ZResultCode, INVALID, NETWORK,
    NULL, PARSE,
};
use crate::bytes::{self, OwnedBytes};
use crate::keyexpr;

const BLOCK: i32 = 0;
const DROP: i32 = 1;
const PRIORITY_DATA: i32 = 5;

/// `z_publisher_options_t`; filled by `z_publisher_options_default` first.
#[repr(C)]
pub struct PublisherOptions {
    encoding: *mut Owned<Encoding>,
    congestion_control: i32,
    priority: i32,
    is_express: bool,
}

#[no_mangle]
pub unsafe extern "C" fn z_encoding_from_str(
    this: *mut Owned<Encoding>,
    text: *const c_char,
) -> ZResultCode {
    guard(|| {
        clear(this)?;
        if text.is_null() {
            return Err(NULL);
        }
        store(
            this,
            Encoding::from(CStr::from_ptr(text).to_str().map_err(|_| PARSE)?),
        );
        Ok(())
    })
}

#[no_mangle]
pub unsafe extern "C" fn z_encoding_drop(this: *mut Owned<Encoding>) {
    guard_void(|| drop(take(this)));
}

#[no_mangle]
pub unsafe extern "C" fn z_publisher_options_default(this: *mut PublisherOptions) {
    if !this.is_null() {
        ptr::write(
            this,
            PublisherOptions {
                encoding: ptr::null_mut(),
                congestion_control: DROP,
                priority: PRIORITY_DATA,
                is_express: false,
            },
        );
    }
}

fn congestion_control(value: i32) -> Result<CongestionControl, ZResultCode> {
    match value {
        BLOCK => Ok(CongestionControl::Block),
        DROP => Ok(CongestionControl::Drop),
        _ => Err(INVALID),
    }
}

#[no_mangle]
pub unsafe extern "C" fn z_declare_publisher(
    session: *const Session,
    this: *mut Owned<Publisher<'static>>,
    key: *const KeyExpr<'static>,
    options: *mut PublisherOptions,
) -> ZResultCode {
    guard(|| {
        clear(this)?;
        let session = session.as_ref().ok_or(NULL)?;
        let mut builder = session.declare_publisher(keyexpr::owned(key)?);
        if let Some(options) = options.as_mut() {
            let priority = u8::try_from(options.priority).map_err(|_| INVALID)?;
            builder = builder
                .congestion_control(congestion_control(options.congestion_control)?)
                .priority(Priority::try_from(priority).map_err(|_| INVALID)?)
                .express(options.is_express);
            if let Some(encoding) = take(options.encoding) {
                builder = builder.encoding(encoding);
            }
        }
        store(this, builder.wait().map_err(|_| NETWORK)?);
        Ok(())
    })
}

#[no_mangle]
pub unsafe extern "C" fn z_publisher_loan(
    this: *const Owned<Publisher<'static>>,
) -> *const Publisher<'static> {
    loan(this)
}

#[no_mangle]
pub unsafe extern "C" fn z_publisher_put(
    this: *const Publisher<'static>,
    payload: *mut OwnedBytes,
    options: *const c_void,
) -> ZResultCode {
    guard(|| {
        let payload = bytes::take(payload)?;
        no_options(options)?;
        this.as_ref()
            .ok_or(NULL)?
            .put(payload)
            .wait()
            .map_err(|_| NETWORK)
    })
}

#[no_mangle]
pub unsafe extern "C" fn z_publisher_drop(this: *mut Owned<Publisher<'static>>) {
    guard_void(|| {
        if let Some(publisher) = take(this) {
            let _ = publisher.undeclare().wait();
        }
    });
}
