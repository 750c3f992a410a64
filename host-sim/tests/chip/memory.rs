//! Memory from which the tick runs. The place of the test that its whole code is linked in static RAM and runs there.
