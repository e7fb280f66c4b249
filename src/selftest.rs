//! `pneuval selftest`: statistical promises, checked at length on rehearsed sessions.
//!
//! | file | promise |
//! |---|---|
//! | `coverage.rs` | 95 % intervals of metrics hold the truth, and are no wider than they must be |
//! | `lag.rs` | clocks by sync events, lags with and without them |

mod bench;
mod coverage;
mod lag;

use crate::cli::{Promise, Selftest};
use crate::exit::{Failure, Outcome};

pub fn run(arguments: &Selftest) -> Result<Outcome, Failure> {
    match &arguments.promise {
        Promise::Coverage(arguments) => coverage::run(arguments),
        Promise::Lag(arguments) => lag::run(arguments),
    }
}
