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
//! | `direction` | which way an input goes |
//! | `parts` | the parts of a model, as plots |
//! | [`identified`] | report of `mgpi identify` |
//! | `bars` | bars with names, in the same look |
//! | [`comparison`] | report of `mgpi compare` |
//! | [`paper_figures`] | report of `mgpi report`: Figs. 8 and 11 to 13 of the paper from own data |

mod bars;
pub mod comparison;
mod direction;
pub mod identified;
mod model_run;
mod page;
pub mod paper_figures;
mod parameters;
mod parts;
pub mod plot;
mod simplify;

pub use plot::DrawingError;
