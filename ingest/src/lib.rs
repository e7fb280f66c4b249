//! Files and units: everything that turns bytes into checked numbers, and numbers into stored files.
//!
//! Nothing here knows a model. Units are text at the edge and SI inside; gauge or absolute is always said.
//!
//! | module | holds |
//! |---|---|
//! | [`units`] | unit symbols, dimensions, conversion to SI |
//! | [`number`] | a printed number with the interval its last digit leaves open |
//! | [`document`] | TOML with file, line and key in every error |
//! | [`table`] | CSV tables with a name row and a unit row |
//! | [`raw`] | a raw file, read from front to back |
//! | [`formats`] | raw logs as instruments write them |
//! | [`camera`] | lengths, angles and areas from pictures |
//! | [`recording`] | what a raw file holds: tables of columns |
//! | [`watch`] | what can be said of a column without keeping it |
//! | [`finding`] | what is odd about recorded data; gaps and steps back in time |
//! | [`manifest`] | the files a user writes: actuators, published datasets, rigs, sessions |
//! | [`calibration`] | from what an instrument puts out to what it measures |
//! | [`draft`] | a first description of logs nobody has described |
//! | [`tensile`] | tests of material strips: nominal stress over stretch, with their defects |
//! | [`session`] | logs to channels in SI units, with findings |
//! | [`inspect`] | what a raw file holds, looked at in little memory |
//! | [`limits`] | sizes checked before anything is read |
//! | [`store`] | Parquet and `session.json`; the only module that sees polars |
//! | [`digest`] | SHA-256, as `sha256sum` prints it |

pub mod calibration;
pub mod camera;
pub mod digest;
pub mod document;
pub mod draft;
pub mod error;
pub mod finding;
pub mod formats;
pub mod inspect;
pub mod limits;
pub mod manifest;
pub mod number;
pub mod raw;
pub mod recording;
pub mod session;
#[cfg(feature = "store")]
pub mod store;
pub mod table;
pub mod tensile;
pub mod units;
pub mod watch;

pub use error::{IngestError, Place};
