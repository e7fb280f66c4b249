//! `pneuval selftest`: statistical promises, checked at length on rehearsed sessions.
//!
//! | file | promise |
//! |---|---|
//! | `lag.rs` | clocks by sync events, lags with and without them |

mod lag;

use crate::cli::{Promise, Selftest};
use crate::exit::{Failure, Outcome};

pub fn run(arguments: &Selftest) -> Result<Outcome, Failure> {
    match &arguments.promise {
        Promise::Lag(arguments) => lag::run(arguments),
    }
}
