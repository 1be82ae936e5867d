//! Files of many loggers: each is read with the right numbers, or refused with a message that names
//! the cure.

mod loggers {
    pub mod bench;
    pub mod layouts;
    pub mod times;
    pub mod values;
}
