//! The benchmark of control: plants, references and controllers, and how well they go together.
//!
//! | file | what it does |
//! |---|---|
//! | [`subject`] | the plants: the rig, and the zoo's |
//! | [`known`] | what the desk makes of a plant's recording: a model, extended, with what it shows of time |
//! | [`mod@reference`] | what is to be tracked |
//! | [`reach`] | how much of that a muscle reaches |
//! | [`course`] | one run of the control code with a plant, tick by tick |
//! | [`controller`] | the controllers that are compared, from the paper's PID to learning |
//! | [`drift`] | half an hour of a muscle that warms up, with and without adaptation |
//! | [`score`] | error, settling and effort of a run |
//! | [`sensitivity`] | the largest sensitivity of a loop, measured |
//!
//! The control code is `model-core`'s in single precision, as on the board; commands have the steps
//! of a converter of 12 bits over 10 bar, measurements those of the plant's own sensors. No
//! emulator takes part.

pub mod controller;
pub mod course;
pub mod drift;
pub mod known;
pub mod reach;
pub mod reference;
pub mod score;
pub mod sensitivity;
pub mod subject;
