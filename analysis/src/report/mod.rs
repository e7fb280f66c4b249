//! Figures and pages, drawn from stored numbers only.

mod chart;
mod figures;
mod group;
mod overlay;
mod page;
mod scene;
pub mod text;
mod view;

pub use figures::{Figure, Files, Told, figures};
pub use overlay::{overlay, thumbnail};
pub use page::{Page, audit_page, pages};
