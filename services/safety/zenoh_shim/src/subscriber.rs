//! Subscribers, and what a callback may ask of a sample.

use std::ffi::c_void;
use std::ptr;

use zenoh::bytes::ZBytes;
use zenoh::key_expr::KeyExpr;
use zenoh::pubsub::Subscriber;
use zenoh::sample::{Sample, SampleKind};
use zenoh::{Session, Wait};

use crate::boundary::{
    clear, guard, guard_void, no_options, store, take, Owned, ZResultCode, NETWORK, NULL,
};
use crate::closure::OwnedClosure;
use crate::keyexpr;

const PUT: i32 = 0;
const DELETE: i32 = 1;

#[no_mangle]
pub unsafe extern "C" fn z_closure_sample(
    this: *mut OwnedClosure<Sample>,
    call: Option<unsafe extern "C" fn(*mut Sample, *mut c_void)>,
    drop: Option<unsafe extern "C" fn(*mut c_void)>,
    context: *mut c_void,
) {
    OwnedClosure::write(this, call, drop, context);
}

#[no_mangle]
pub unsafe extern "C" fn z_closure_sample_drop(this: *mut OwnedClosure<Sample>) {
    guard_void(|| drop(OwnedClosure::take(this)));
}

#[no_mangle]
pub unsafe extern "C" fn z_declare_subscriber(
    session: *const Session,
    this: *mut Owned<Subscriber<()>>,
    key: *const KeyExpr<'static>,
    callback: *mut OwnedClosure<Sample>,
    options: *const c_void,
) -> ZResultCode {
    guard(|| {
        let callback = OwnedClosure::take(callback)?;
        clear(this)?;
        no_options(options)?;
        let session = session.as_ref().ok_or(NULL)?;
        let subscriber = session
            .declare_subscriber(keyexpr::owned(key)?)
            .callback(move |sample| callback.run(sample))
            .wait();
        store(this, subscriber.map_err(|_| NETWORK)?);
        Ok(())
    })
}

/// Undeclares and waits for callbacks that are running.
#[no_mangle]
pub unsafe extern "C" fn z_subscriber_drop(this: *mut Owned<Subscriber<()>>) {
    guard_void(|| {
        if let Some(subscriber) = take(this) {
            let _ = subscriber.undeclare().wait_callbacks().wait();
        }
    });
}

#[no_mangle]
pub unsafe extern "C" fn z_sample_payload(this: *const Sample) -> *const ZBytes {
    this.as_ref().map_or(ptr::null(), |sample| sample.payload())
}

#[no_mangle]
pub unsafe extern "C" fn z_sample_keyexpr(this: *const Sample) -> *const KeyExpr<'static> {
    this.as_ref()
        .map_or(ptr::null(), |sample| sample.key_expr())
}

#[no_mangle]
pub unsafe extern "C" fn z_sample_kind(this: *const Sample) -> i32 {
    match this.as_ref().map(Sample::kind) {
        Some(SampleKind::Put) => PUT,
        _ => DELETE,
    }
}
