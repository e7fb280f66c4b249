//! Raw logs as instruments write them: one reader per format, its writer beside it.
//!
//! A reader keeps every sample where it stood, turns what is no number into a hole, and tells each such place as a
//! [`Finding`](crate::finding::Finding). It never repairs and never interpolates.

pub mod csv;
