//! Records of numbers whose fields are listed once, where they are declared.
//!
//! `record!` declares a structure over a scalar and gives it `cast` and [`Fields`]. Every other pass over its fields (a
//! hash, source for a firmware) is a [`Visitor`]. So a new field is cast, hashed and written out without further work. No
//! tick uses any of this.

use crate::scalar::Scalar;

/// Something whose parts can be visited in the order in which they are declared.
pub trait Fields<S> {
    /// Visits every part.
    fn visit(&self, visitor: &mut impl Visitor<S>);
}

/// Operation on each part of a [`Fields`].
pub trait Visitor<S> {
    /// A number that is cast with its record.
    fn number(&mut self, x: S);

    /// A whole number: a count, ticks.
    fn integer(&mut self, x: i64);

    /// A variant of an enumeration, by the names of both and by its number, which never changes.
    fn word(&mut self, kind: &'static str, name: &'static str, number: u32);

    /// Something that may be absent.
    fn option(&mut self, value: Option<&impl Fields<S>>);

    /// Several parts that belong together; `parts` visits them.
    fn group(&mut self, _: Group, parts: impl FnOnce(&mut Self)) {
        parts(self);
    }

    /// One field of a [`Group::Record`].
    fn field(&mut self, _: &'static str, value: &impl Fields<S>)
    where
        Self: Sized,
    {
        value.visit(self);
    }
}

/// Grouping of the parts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Group {
    /// A structure of this name with named fields.
    Record(&'static str),
    /// A call of this function with the parts as arguments.
    Call(&'static str),
    /// A tuple.
    Tuple,
    /// A list with an entry per joint.
    List,
}

/// The same in another scalar, each number through [`Scalar::literal`].
pub(crate) trait Cast {
    type In<T: Scalar>;

    fn cast_to<T: Scalar>(&self) -> Self::In<T>;
}

impl Cast for f64 {
    type In<T: Scalar> = T;

    fn cast_to<T: Scalar>(&self) -> T {
        T::literal(*self)
    }
}

impl<S: Scalar> Fields<S> for S {
    fn visit(&self, visitor: &mut impl Visitor<S>) {
        visitor.number(*self);
    }
}

macro_rules! integers {
    ($($integer:ty)*) => {$(
        impl Cast for $integer {
            type In<T: Scalar> = Self;

            fn cast_to<T: Scalar>(&self) -> Self {
                *self
            }
        }

        impl<S> Fields<S> for $integer {
            fn visit(&self, visitor: &mut impl Visitor<S>) {
                visitor.integer((*self).into());
            }
        }
    )*};
}

integers!(u32 i32);

impl<F: Cast, const N: usize> Cast for [F; N] {
    type In<T: Scalar> = [F::In<T>; N];

    fn cast_to<T: Scalar>(&self) -> Self::In<T> {
        self.each_ref().map(F::cast_to)
    }
}

impl<S, F: Fields<S>, const N: usize> Fields<S> for [F; N] {
    fn visit(&self, visitor: &mut impl Visitor<S>) {
        visitor.group(Group::List, |visitor| self.iter().for_each(|entry| entry.visit(visitor)));
    }
}

impl<F: Cast> Cast for (F, F) {
    type In<T: Scalar> = (F::In<T>, F::In<T>);

    fn cast_to<T: Scalar>(&self) -> Self::In<T> {
        (self.0.cast_to(), self.1.cast_to())
    }
}

impl<S, F: Fields<S>> Fields<S> for (F, F) {
    fn visit(&self, visitor: &mut impl Visitor<S>) {
        visitor.group(Group::Tuple, |visitor| {
            self.0.visit(visitor);
            self.1.visit(visitor);
        });
    }
}

impl<F: Cast> Cast for Option<F> {
    type In<T: Scalar> = Option<F::In<T>>;

    fn cast_to<T: Scalar>(&self) -> Self::In<T> {
        self.as_ref().map(F::cast_to)
    }
}

impl<S, F: Fields<S>> Fields<S> for Option<F> {
    fn visit(&self, visitor: &mut impl Visitor<S>) {
        visitor.option(self.as_ref());
    }
}

/// Declares a structure over a scalar `S` (and a number of joints), with `cast` and [`Fields`]. If its fields are private, `made by` names
/// the function that makes it from their values.
macro_rules! record {
    (
        $(#[$about:meta])*
        pub struct $name:ident<S $(, const $n:ident: usize)?> {
            $($(#[$what:meta])* pub $field:ident: $kind:ty,)*
        }
    ) => {
        $(#[$about])*
        pub struct $name<S $(, const $n: usize)?> {
            $($(#[$what])* pub $field: $kind,)*
        }

        $crate::fields::record!(@cast $name [$($n)?] $($field)*);

        impl<S: $crate::scalar::Scalar $(, const $n: usize)?> $crate::fields::Fields<S> for $name<S $(, $n)?> {
            fn visit(&self, visitor: &mut impl $crate::fields::Visitor<S>) {
                visitor.group($crate::fields::Group::Record(stringify!($name)), |visitor| {
                    $(visitor.field(stringify!($field), &self.$field);)*
                });
            }
        }
    };
    (
        $(#[$about:meta])*
        pub struct $name:ident<S> made by $function:ident {
            $($(#[$what:meta])* $field:ident: $kind:ty,)*
        }
    ) => {
        $(#[$about])*
        pub struct $name<S> {
            $($(#[$what])* $field: $kind,)*
        }

        $crate::fields::record!(@cast $name [] $($field)*);

        impl<S: $crate::scalar::Scalar> $crate::fields::Fields<S> for $name<S> {
            fn visit(&self, visitor: &mut impl $crate::fields::Visitor<S>) {
                let function = concat!(stringify!($name), "::", stringify!($function));
                visitor.group($crate::fields::Group::Call(function), |visitor| {
                    $($crate::fields::Fields::<S>::visit(&self.$field, visitor);)*
                });
            }
        }
    };
    (@cast $name:ident [$($n:ident)?] $($field:ident)*) => {
        impl<$(const $n: usize)?> $name<f64 $(, $n)?> {
            /// The same in another scalar, each number through [`crate::Scalar::literal`].
            #[must_use]
            pub fn cast<T: $crate::scalar::Scalar>(&self) -> $name<T $(, $n)?> {
                $name { $($field: $crate::fields::Cast::cast_to::<T>(&self.$field)),* }
            }
        }

        impl<$(const $n: usize)?> $crate::fields::Cast for $name<f64 $(, $n)?> {
            type In<T: $crate::scalar::Scalar> = $name<T $(, $n)?>;

            fn cast_to<T: $crate::scalar::Scalar>(&self) -> Self::In<T> {
                self.cast()
            }
        }
    };
}

/// Lists the variants of an enumeration that is a field of a `record!`, each with its number in hashes, which never changes.
macro_rules! words {
    ($name:ident { $($variant:ident = $number:literal),* $(,)? }) => {
        impl $crate::fields::Cast for $name {
            type In<T: $crate::scalar::Scalar> = Self;

            fn cast_to<T: $crate::scalar::Scalar>(&self) -> Self {
                *self
            }
        }

        impl<S> $crate::fields::Fields<S> for $name {
            fn visit(&self, visitor: &mut impl $crate::fields::Visitor<S>) {
                let (name, number) = match self {
                    $(Self::$variant => (stringify!($variant), $number),)*
                };
                visitor.word(stringify!($name), name, number);
            }
        }
    };
}

pub(crate) use {record, words};
