//! Robot and scene files to a checked model.
