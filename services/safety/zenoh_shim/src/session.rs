//! Log, configuration, session, and the liveliness token that lives with it.

use std::ffi::{c_char, c_int, c_void, CStr};

use zenoh::key_expr::KeyExpr;
use zenoh::liveliness::LivelinessToken;
use zenoh::{Config, Session, Wait};

use crate::boundary::{
    clear, guard, guard_void, loan, no_options, store, take, Owned, ZResultCode, NETWORK, NULL,
    PARSE,
};
use crate::keyexpr;

extern "C" {
    fn signal(number: c_int, handler: usize) -> usize;
}

const SIGPIPE: c_int = 13;
const SIG_IGN: usize = 1;

#[no_mangle]
pub unsafe extern "C" fn zc_init_log_from_env_or(filter: *const c_char) -> ZResultCode {
    guard(|| {
        if filter.is_null() {
            return Err(NULL);
        }
        zenoh::init_log_from_env_or(CStr::from_ptr(filter).to_str().map_err(|_| PARSE)?);
        Ok(())
    })
}

#[no_mangle]
pub unsafe extern "C" fn zc_config_from_str(
    this: *mut Owned<Config>,
    json5: *const c_char,
) -> ZResultCode {
    guard(|| {
        clear(this)?;
        if json5.is_null() {
            return Err(NULL);
        }
        let text = CStr::from_ptr(json5).to_str().map_err(|_| PARSE)?;
        store(this, Config::from_json5(text).map_err(|_| PARSE)?);
        Ok(())
    })
}

#[no_mangle]
pub unsafe extern "C" fn z_config_drop(this: *mut Owned<Config>) {
    guard_void(|| drop(take(this)));
}

#[no_mangle]
pub unsafe extern "C" fn z_open(
    this: *mut Owned<Session>,
    config: *mut Owned<Config>,
    options: *const c_void,
) -> ZResultCode {
    guard(|| {
        let config = take(config);
        clear(this)?;
        no_options(options)?;
        // A peer or a log reader that goes away must not end the process.
        signal(SIGPIPE, SIG_IGN);
        let session = zenoh::open(config.ok_or(NULL)?).wait();
        store(
            this,
            session.map_err(|error| {
                eprintln!("zenoh: cannot open the session: {error}");
                NETWORK
            })?,
        );
        Ok(())
    })
}

#[no_mangle]
pub unsafe extern "C" fn z_session_loan(this: *const Owned<Session>) -> *const Session {
    loan(this)
}

/// Closes the session and waits for callbacks that are running.
#[no_mangle]
pub unsafe extern "C" fn z_session_drop(this: *mut Owned<Session>) {
    guard_void(|| {
        if let Some(session) = take(this) {
            let _ = session.close().wait_callbacks().wait();
        }
    });
}

#[no_mangle]
pub unsafe extern "C" fn z_liveliness_declare_token(
    session: *const Session,
    this: *mut Owned<LivelinessToken>,
    key: *const KeyExpr<'static>,
    options: *const c_void,
) -> ZResultCode {
    guard(|| {
        clear(this)?;
        no_options(options)?;
        let session = session.as_ref().ok_or(NULL)?;
        let token = session
            .liveliness()
            .declare_token(keyexpr::owned(key)?)
            .wait();
        store(this, token.map_err(|_| NETWORK)?);
        Ok(())
    })
}

#[no_mangle]
pub unsafe extern "C" fn z_liveliness_token_drop(this: *mut Owned<LivelinessToken>) {
    guard_void(|| {
        if let Some(token) = take(this) {
            let _ = token.undeclare().wait();
        }
    });
}
