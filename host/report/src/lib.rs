//! Reports: one self-contained HTML file each.
//!
//! # Design
//! | file | what it does |
//! |---|---|
//! | [`plot`], `axis` | lines over two axes, in the one look of all plots |
//! | `simplify` | fewer points for the same picture |
//! | `page`, `plot.js` | the page around the plots, and the plots' script: enlarge, point at, export |
//! | `model_run` | a model beside a recording, as plots |
//! | `parameters` | the parameters and what is known about them, as a table |
//! | `parts` | the parts of a model, as plots |
//! | [`identified`] | report of `mgpi identify` |
//! | `tracked` | report of `mgpi pil` |
//! | `tracking` | a tracking run, as plots |
//! | [`tuned`] | report of `mgpi tune` |
//! | `table` | tables that a phone shows as cards |
//! | `bars` | bars with names, in the same look |
//! | [`diagnosed`] | report of `mgpi diagnose` |
//! | [`comparison`] | report of `mgpi compare` |
//! | [`joint`] | reports of `mgpi identify --joint` and `mgpi pil --joint` |
//! | [`archive`] | report of `mgpi batch`: many recordings, muscle by muscle |
//! | `paper_figures` | report of `mgpi report`: Figs. 8 and 11 to 13 of the paper from own data |

pub mod archive;
mod axis;
pub mod bars;
pub mod comparison;
pub mod diagnosed;
pub mod identified;
pub mod joint;
mod model_run;
pub mod page;
#[cfg(feature = "runs")]
pub mod paper_figures;
mod parameters;
mod parts;
pub mod plot;
mod simplify;
mod table;
#[cfg(feature = "runs")]
pub mod tracked;
#[cfg(feature = "runs")]
pub mod tracking;
pub mod tuned;
