//! Reports: one self-contained HTML file each.
//!
//! # Design
//! | file | what it does |
//! |---|---|
//! | [`plot`] | lines over two axes, in the one look of all plots |
//! | `simplify` | fewer points for the same picture |
//! | `page` | the page around the plots |
//! | `model_run` | a model beside a recording, as plots |
//! | `parameters` | the parameters and what is known about them, as a table |
//! | [`identified`] | report of `mgpi identify` |
//! | [`paper_figures`] | report of `mgpi report`: Figs. 8 and 11 to 13 of the paper from own data |

pub mod identified;
mod model_run;
mod page;
pub mod paper_figures;
mod parameters;
pub mod plot;
mod simplify;

pub use plot::DrawingError;
