//! The numbers that lanes hold, and what each operation does to them.
//!
//! [`Number`] is f32 (the GPU's precision) or f64 (the reference). Everything is branch-free and marked for inlining, so that a loop over
//! lanes becomes vector code under whatever target features its caller has; the same source gives the same bits on every kernel
//! class that multiplies and adds in one rounding, and on every class that does not.

mod elementary_f32;

use super::op::Op;

/// An element of a lane slot. Masks are all bits or none; integers are the low 32 bits.
pub trait Number: Copy + Default + PartialOrd + Send + Sync + 'static {
    fn from_f64(v: f64) -> Self;
    fn to_f64(self) -> f64;
    fn from_u32(bits: u32) -> Self;
    fn to_u32(self) -> u32;
    fn from_mask(set: bool) -> Self;
    fn is_set(self) -> bool;
    fn bit_and(self, b: Self) -> Self;
    fn bit_or(self, b: Self) -> Self;
    fn bit_xor(self, b: Self) -> Self;
    fn add(self, b: Self) -> Self;
    fn sub(self, b: Self) -> Self;
    fn mul(self, b: Self) -> Self;
    fn div(self, b: Self) -> Self;
    fn rem(self, b: Self) -> Self;
    fn neg(self) -> Self;
    fn abs(self) -> Self;
    fn floor(self) -> Self;
    fn ceil(self) -> Self;
    fn trunc(self) -> Self;
    fn round(self) -> Self;
    fn sqrt(self) -> Self;
    /// Rounded once.
    fn fused(self, b: Self, c: Self) -> Self;
    fn exp(self) -> Self;
    fn exp2(self) -> Self;
    fn log(self) -> Self;
    fn log2(self) -> Self;
    fn pow(self, y: Self) -> Self;
    fn sin(self) -> Self;
    fn cos(self) -> Self;
    fn asin(self) -> Self;
    fn acos(self) -> Self;
    fn atan(self) -> Self;
    fn atan2(self, x: Self) -> Self;
    /// Saturating; NaN gives 0 (WGSL leaves NaN open).
    fn to_i32_saturating(self) -> i32;
    fn to_u32_saturating(self) -> u32;
    fn from_i32_value(v: i32) -> Self;
    fn from_u32_value(v: u32) -> Self;
    fn bits_of_f32(self) -> u32;
    fn from_bits_of_f32(bits: u32) -> Self;
}

macro_rules! shared_float_methods {
    ($float:ty, $bits:ty) => {
        #[inline(always)]
        fn from_f64(v: f64) -> Self {
            v as $float
        }
        #[inline(always)]
        fn to_f64(self) -> f64 {
            f64::from(self)
        }
        #[inline(always)]
        fn from_u32(bits: u32) -> Self {
            <$float>::from_bits(<$bits>::from(bits))
        }
        #[inline(always)]
        fn to_u32(self) -> u32 {
            self.to_bits() as u32
        }
        #[inline(always)]
        fn from_mask(set: bool) -> Self {
            <$float>::from_bits(if set { <$bits>::MAX } else { 0 })
        }
        #[inline(always)]
        fn is_set(self) -> bool {
            self.to_bits() != 0
        }
        #[inline(always)]
        fn bit_and(self, b: Self) -> Self {
            <$float>::from_bits(self.to_bits() & b.to_bits())
        }
        #[inline(always)]
        fn bit_or(self, b: Self) -> Self {
            <$float>::from_bits(self.to_bits() | b.to_bits())
        }
        #[inline(always)]
        fn bit_xor(self, b: Self) -> Self {
            <$float>::from_bits(self.to_bits() ^ b.to_bits())
        }
        #[inline(always)]
        fn add(self, b: Self) -> Self {
            self + b
        }
        #[inline(always)]
        fn sub(self, b: Self) -> Self {
            self - b
        }
        #[inline(always)]
        fn mul(self, b: Self) -> Self {
            self * b
        }
        #[inline(always)]
        fn div(self, b: Self) -> Self {
            self / b
        }
        /// a - b trunc(a / b), as WGSL defines %.
        #[inline(always)]
        fn rem(self, b: Self) -> Self {
            self - b * (self / b).trunc()
        }
        #[inline(always)]
        fn neg(self) -> Self {
            -self
        }
        #[inline(always)]
        fn abs(self) -> Self {
            <$float>::abs(self)
        }
        #[inline(always)]
        fn floor(self) -> Self {
            <$float>::floor(self)
        }
        #[inline(always)]
        fn ceil(self) -> Self {
            <$float>::ceil(self)
        }
        #[inline(always)]
        fn trunc(self) -> Self {
            <$float>::trunc(self)
        }
        #[inline(always)]
        fn round(self) -> Self {
            <$float>::round_ties_even(self)
        }
        #[inline(always)]
        fn sqrt(self) -> Self {
            <$float>::sqrt(self)
        }
        #[inline(always)]
        fn fused(self, b: Self, c: Self) -> Self {
            <$float>::mul_add(self, b, c)
        }
        #[inline(always)]
        fn to_i32_saturating(self) -> i32 {
            self as i32
        }
        #[inline(always)]
        fn to_u32_saturating(self) -> u32 {
            self as u32
        }
        #[inline(always)]
        fn from_i32_value(v: i32) -> Self {
            v as $float
        }
        #[inline(always)]
        fn from_u32_value(v: u32) -> Self {
            v as $float
        }
    };
}

impl Number for f32 {
    shared_float_methods!(f32, u32);
    #[inline(always)]
    fn bits_of_f32(self) -> u32 {
        self.to_bits()
    }
    #[inline(always)]
    fn from_bits_of_f32(bits: u32) -> Self {
        Self::from_bits(bits)
    }
    #[inline(always)]
    fn exp(self) -> Self {
        elementary_f32::exp(self)
    }
    #[inline(always)]
    fn exp2(self) -> Self {
        elementary_f32::exp2(self)
    }
    #[inline(always)]
    fn log(self) -> Self {
        elementary_f32::log(self)
    }
    #[inline(always)]
    fn log2(self) -> Self {
        elementary_f32::log2(self)
    }
    #[inline(always)]
    fn pow(self, y: Self) -> Self {
        elementary_f32::pow(self, y)
    }
    #[inline(always)]
    fn sin(self) -> Self {
        elementary_f32::sin(self)
    }
    #[inline(always)]
    fn cos(self) -> Self {
        elementary_f32::cos(self)
    }
    #[inline(always)]
    fn asin(self) -> Self {
        elementary_f32::asin(self)
    }
    #[inline(always)]
    fn acos(self) -> Self {
        elementary_f32::acos(self)
    }
    #[inline(always)]
    fn atan(self) -> Self {
        elementary_f32::atan(self)
    }
    #[inline(always)]
    fn atan2(self, x: Self) -> Self {
        elementary_f32::atan2(self, x)
    }
}

/// The reference precision takes its elementary functions from the standard library: right to an ulp, and not in a hurry.
impl Number for f64 {
    shared_float_methods!(f64, u64);
    #[inline(always)]
    fn bits_of_f32(self) -> u32 {
        (self as f32).to_bits()
    }
    #[inline(always)]
    fn from_bits_of_f32(bits: u32) -> Self {
        f64::from(f32::from_bits(bits))
    }
    fn exp(self) -> Self {
        f64::exp(self)
    }
    fn exp2(self) -> Self {
        f64::exp2(self)
    }
    fn log(self) -> Self {
        f64::ln(self)
    }
    fn log2(self) -> Self {
        f64::log2(self)
    }
    fn pow(self, y: Self) -> Self {
        if self < 0.0 { f64::NAN } else { f64::powf(self, y) }
    }
    fn sin(self) -> Self {
        f64::sin(self)
    }
    fn cos(self) -> Self {
        f64::cos(self)
    }
    fn asin(self) -> Self {
        f64::asin(self)
    }
    fn acos(self) -> Self {
        f64::acos(self)
    }
    fn atan(self) -> Self {
        f64::atan(self)
    }
    fn atan2(self, x: Self) -> Self {
        f64::atan2(self, x)
    }
}

/// An operation as a type, so that a loop over lanes is made for each.
pub trait Operation {
    /// `FUSED`: the class multiplies and adds in one rounding.
    fn apply<R: Number, const FUSED: bool>(a: R, b: R, c: R) -> R;
}

#[inline(always)]
fn int<R: Number>(v: i32) -> R {
    R::from_u32(v as u32)
}

#[inline(always)]
fn select<R: Number>(mask: bool, a: R, b: R) -> R {
    if mask { a } else { b }
}

/// Gives each operation its type, and `with_operation!(op, T => expr)` that names the type of a value of [`Op`].
macro_rules! operations {
    ($($name:ident($a:ident, $b:ident, $c:ident) = $body:expr;)*) => {
        /// One type per operation.
        pub mod kinds {
            $(pub struct $name;)*
        }
        $(impl Operation for kinds::$name {
            #[inline(always)]
            fn apply<R: Number, const FUSED: bool>($a: R, $b: R, $c: R) -> R {
                let _ = ($a, $b, $c);
                $body
            }
        })*
        /// Calls the visitor with the operation's type; `None` for what works across lanes.
        pub fn visit<V: Visitor>(op: Op, visitor: V) -> Option<V::Out> {
            match op {
                $(Op::$name => Some(visitor.visit::<kinds::$name>()),)*
                Op::DerivativeX | Op::DerivativeY => None,
            }
        }
    };
}

/// What to do with an operation's type.
pub trait Visitor {
    type Out;
    fn visit<O: Operation>(self) -> Self::Out;
}

operations! {
    Copy(a, b, c) = a;
    Add(a, b, c) = a.add(b);
    Sub(a, b, c) = a.sub(b);
    Mul(a, b, c) = a.mul(b);
    Div(a, b, c) = a.div(b);
    Rem(a, b, c) = a.rem(b);
    MulAdd(a, b, c) = if FUSED { a.fused(b, c) } else { a.mul(b).add(c) };
    NegMulAdd(a, b, c) = if FUSED { a.neg().fused(b, c) } else { c.sub(a.mul(b)) };
    Neg(a, b, c) = a.neg();
    Abs(a, b, c) = a.abs();
    // The second argument where either is NaN.
    Min(a, b, c) = select(a < b, a, b);
    Max(a, b, c) = select(a > b, a, b);
    Floor(a, b, c) = a.floor();
    Ceil(a, b, c) = a.ceil();
    Trunc(a, b, c) = a.trunc();
    Round(a, b, c) = a.round();
    Fract(a, b, c) = a.sub(a.floor());
    Sign(a, b, c) = select(a > R::default(), R::from_f64(1.0), select(a < R::default(), R::from_f64(-1.0), R::default()));
    Sqrt(a, b, c) = a.sqrt();
    InverseSqrt(a, b, c) = R::from_f64(1.0).div(a.sqrt());
    Exp(a, b, c) = a.exp();
    Exp2(a, b, c) = a.exp2();
    Log(a, b, c) = a.log();
    Log2(a, b, c) = a.log2();
    Pow(a, b, c) = a.pow(b);
    Sin(a, b, c) = a.sin();
    Cos(a, b, c) = a.cos();
    Tan(a, b, c) = a.sin().div(a.cos());
    Asin(a, b, c) = a.asin();
    Acos(a, b, c) = a.acos();
    Atan(a, b, c) = a.atan();
    Atan2(a, b, c) = a.atan2(b);
    Less(a, b, c) = R::from_mask(a < b);
    LessEqual(a, b, c) = R::from_mask(a <= b);
    Equal(a, b, c) = R::from_mask(a == b);
    NotEqual(a, b, c) = R::from_mask(a != b);
    And(a, b, c) = a.bit_and(b);
    Or(a, b, c) = a.bit_or(b);
    Xor(a, b, c) = a.bit_xor(b);
    // Masks and integers alike: the high half of a double-precision slot only matters to masks.
    Not(a, b, c) = a.bit_xor(R::from_mask(true));
    Select(a, b, c) = select(c.is_set(), a, b);
    IntAdd(a, b, c) = R::from_u32(a.to_u32().wrapping_add(b.to_u32()));
    IntSub(a, b, c) = R::from_u32(a.to_u32().wrapping_sub(b.to_u32()));
    IntMul(a, b, c) = R::from_u32(a.to_u32().wrapping_mul(b.to_u32()));
    IntNeg(a, b, c) = R::from_u32(a.to_u32().wrapping_neg());
    // Division by zero gives the dividend, as WGSL says.
    IntDiv(a, b, c) = int((a.to_u32() as i32).wrapping_div(if b.to_u32() == 0 { 1 } else { b.to_u32() as i32 }));
    UintDiv(a, b, c) = R::from_u32(a.to_u32() / b.to_u32().max(1));
    IntRem(a, b, c) = int((a.to_u32() as i32).wrapping_rem(if b.to_u32() == 0 { 1 } else { b.to_u32() as i32 }));
    UintRem(a, b, c) = R::from_u32(a.to_u32() % b.to_u32().max(1));
    IntMin(a, b, c) = int((a.to_u32() as i32).min(b.to_u32() as i32));
    IntMax(a, b, c) = int((a.to_u32() as i32).max(b.to_u32() as i32));
    UintMin(a, b, c) = R::from_u32(a.to_u32().min(b.to_u32()));
    UintMax(a, b, c) = R::from_u32(a.to_u32().max(b.to_u32()));
    IntLess(a, b, c) = R::from_mask((a.to_u32() as i32) < b.to_u32() as i32);
    UintLess(a, b, c) = R::from_mask(a.to_u32() < b.to_u32());
    IntLessEqual(a, b, c) = R::from_mask(a.to_u32() as i32 <= b.to_u32() as i32);
    UintLessEqual(a, b, c) = R::from_mask(a.to_u32() <= b.to_u32());
    IntEqual(a, b, c) = R::from_mask(a.to_u32() == b.to_u32());
    IntNotEqual(a, b, c) = R::from_mask(a.to_u32() != b.to_u32());
    ShiftLeft(a, b, c) = R::from_u32(a.to_u32() << (b.to_u32() & 31));
    IntShiftRight(a, b, c) = int(a.to_u32() as i32 >> (b.to_u32() & 31));
    UintShiftRight(a, b, c) = R::from_u32(a.to_u32() >> (b.to_u32() & 31));
    IntToFloat(a, b, c) = R::from_i32_value(a.to_u32() as i32);
    UintToFloat(a, b, c) = R::from_u32_value(a.to_u32());
    FloatToInt(a, b, c) = int(a.to_i32_saturating());
    FloatToUint(a, b, c) = R::from_u32(a.to_u32_saturating());
    MaskToInt(a, b, c) = R::from_u32(u32::from(a.is_set()));
    IntToMask(a, b, c) = R::from_mask(a.to_u32() != 0);
    FloatBits(a, b, c) = R::from_u32(a.bits_of_f32());
    BitsFloat(a, b, c) = R::from_bits_of_f32(a.to_u32());
}

/// One operation on single values, with the rounding of the class: the uniform tape, and the oracle of the lanes' tests.
pub fn scalar<R: Number>(op: Op, fused: bool, args: [R; 3]) -> R {
    struct One<R>(bool, [R; 3]);
    impl<R: Number> Visitor for One<R> {
        type Out = R;
        fn visit<O: Operation>(self) -> R {
            let [a, b, c] = self.1;
            if self.0 { O::apply::<R, true>(a, b, c) } else { O::apply::<R, false>(a, b, c) }
        }
    }
    // The same value in every lane of a quad differs from none of its neighbours.
    visit(op, One(fused, args)).unwrap_or_default()
}
