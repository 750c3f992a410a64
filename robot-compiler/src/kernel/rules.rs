//! Rules of level `exact` by name; the rewrites are in `rewrites`.

/// One rewrite.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RewriteRule {
    /// Operations on numbers alone are done by the compiler.
    Fold,
    /// `0 x = 0`, `x + 0 = x`, `0 - x = -x`, `x - x = 0`, `0 / x = 0`.
    Zero,
    /// `1 x = x`, `-1 x = -x`, `x / 1 = x`.
    One,
    /// Signs move outward until a sum absorbs them.
    Signs,
    /// `a + b` is `b + a`: one order, so that both are shared.
    Order,
    /// Equal expressions are computed once.
    Share,
}

impl RewriteRule {
    /// All of them.
    pub const ALL: [Self; 6] = [Self::Fold, Self::Zero, Self::One, Self::Signs, Self::Order, Self::Share];

    /// Its name in tables.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Fold => "folding of numbers",
            Self::Zero => "zeros",
            Self::One => "ones",
            Self::Signs => "signs",
            Self::Order => "order of operands",
            Self::Share => "sharing",
        }
    }
}

/// The set of active rules.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RuleSet(u8);

impl RuleSet {
    /// Every rule.
    pub const ALL: Self = Self(0x3f);
    /// No rule: the operations of the recursion unchanged.
    pub const NONE: Self = Self(0);

    /// Every rule but one, to measure what it saves.
    #[must_use]
    pub const fn without(self, rule: RewriteRule) -> Self {
        Self(self.0 & !(1 << rule as u8))
    }

    /// True if a rule is active.
    #[must_use]
    pub const fn contains(self, rule: RewriteRule) -> bool {
        self.0 & (1 << rule as u8) != 0
    }
}
