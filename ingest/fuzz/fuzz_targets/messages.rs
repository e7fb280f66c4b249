#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| pneuval_ingest_fuzz::read_messages(bytes));
