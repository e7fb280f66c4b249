//! Figures and pages, drawn from stored numbers only.

mod chart;
mod figures;
mod group;
mod overlay;
mod page;
pub mod text;
mod view;

pub use figures::{Figure, figures};
pub use overlay::{overlay, thumbnail};
pub use page::{Page, pages};
