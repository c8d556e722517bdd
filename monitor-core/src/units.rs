//! Units at the door: what a sample is measured in. Inside the core every value is a plain `f32`.

macro_rules! unit {
    ($(#[$doc:meta])* $name:ident) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd)]
        #[cfg_attr(feature = "defmt", derive(defmt::Format))]
        pub struct $name(pub f32);

        impl From<$name> for f32 {
            fn from(value: $name) -> f32 {
                value.0
            }
        }
    };
}

unit! {
    /// Angular speed of the shaft, rad/s.
    RadPerSec
}
unit! {
    /// Armature current, A.
    Amperes
}
unit! {
    /// Armature voltage, V: the output of the current controller.
    Volts
}
