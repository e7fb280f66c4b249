//! stub
pub fn looks_like(_h: &[u8], _w: bool) -> bool {
    false
}
pub fn read(
    raw: &crate::raw::RawFile,
    keep: crate::recording::Keep,
) -> Result<crate::recording::Recording, crate::IngestError> {
    super::csv::read_raw(raw, &Default::default(), keep)
}
