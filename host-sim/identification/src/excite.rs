//! excite
