//! Queryables: a query is answered in its callback and finished when that returns.

use std::ffi::c_void;
use std::ptr;

use zenoh::bytes::ZBytes;
use zenoh::key_expr::KeyExpr;
use zenoh::query::{Query, Queryable};
use zenoh::{Session, Wait};

use crate::boundary::{
    clear, guard, guard_void, no_options, store, take, Owned, ZResultCode, NETWORK, NULL,
};
use crate::bytes::{self, OwnedBytes};
use crate::closure::OwnedClosure;
use crate::keyexpr;

#[no_mangle]
pub unsafe extern "C" fn z_closure_query(
    this: *mut OwnedClosure<Query>,
    call: Option<unsafe extern "C" fn(*mut Query, *mut c_void)>,
    drop: Option<unsafe extern "C" fn(*mut c_void)>,
    context: *mut c_void,
) {
    OwnedClosure::write(this, call, drop, context);
}

#[no_mangle]
pub unsafe extern "C" fn z_closure_query_drop(this: *mut OwnedClosure<Query>) {
    guard_void(|| drop(OwnedClosure::take(this)));
}

#[no_mangle]
pub unsafe extern "C" fn z_declare_queryable(
    session: *const Session,
    this: *mut Owned<Queryable<()>>,
    key: *const KeyExpr<'static>,
    callback: *mut OwnedClosure<Query>,
    options: *const c_void,
) -> ZResultCode {
    guard(|| {
        let callback = OwnedClosure::take(callback)?;
        clear(this)?;
        no_options(options)?;
        let session = session.as_ref().ok_or(NULL)?;
        let queryable = session
            .declare_queryable(keyexpr::owned(key)?)
            .callback(move |query| callback.run(query))
            .wait();
        store(this, queryable.map_err(|_| NETWORK)?);
        Ok(())
    })
}

/// Undeclares and waits for callbacks that are running.
#[no_mangle]
pub unsafe extern "C" fn z_queryable_drop(this: *mut Owned<Queryable<()>>) {
    guard_void(|| {
        if let Some(queryable) = take(this) {
            let _ = queryable.undeclare().wait_callbacks().wait();
        }
    });
}

#[no_mangle]
pub unsafe extern "C" fn z_query_keyexpr(this: *const Query) -> *const KeyExpr<'static> {
    this.as_ref()
        .map_or(ptr::null(), |query| query.key_expr())
}

#[no_mangle]
pub unsafe extern "C" fn z_query_payload(this: *const Query) -> *const ZBytes {
    this.as_ref()
        .and_then(Query::payload)
        .map_or(ptr::null(), ptr::from_ref)
}

#[no_mangle]
pub unsafe extern "C" fn z_query_reply(
    this: *const Query,
    key: *const KeyExpr<'static>,
    payload: *mut OwnedBytes,
    options: *const c_void,
) -> ZResultCode {
    guard(|| {
        let payload = bytes::take(payload)?;
        no_options(options)?;
        let query = this.as_ref().ok_or(NULL)?;
        query
            .reply(keyexpr::owned(key)?, payload)
            .wait()
            .map_err(|_| NETWORK)
    })
}

#[no_mangle]
pub unsafe extern "C" fn z_query_reply_err(
    this: *const Query,
    payload: *mut OwnedBytes,
    options: *const c_void,
) -> ZResultCode {
    guard(|| {
        let payload = bytes::take(payload)?;
        no_options(options)?;
        this.as_ref()
            .ok_or(NULL)?
            .reply_err(payload)
            .wait()
            .map_err(|_| NETWORK)
    })
}
