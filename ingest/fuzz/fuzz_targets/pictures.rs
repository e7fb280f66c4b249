#![no_main]

use libfuzzer_sys::fuzz_target;
use pneuval_ingest::formats::Format;

fuzz_target!(|bytes: &[u8]| pneuval_ingest_fuzz::read(Format::Pictures, bytes));
