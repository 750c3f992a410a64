//! Examples and exercises of the robot-dynamics chapter (Jazar, *Theory of Applied Robotics*, chapter 12): closed forms compared with the general
//! code. Wrong printed forms are kept to show that they are wrong.
#![allow(clippy::unwrap_used, reason = "an arm that cannot be built should stop the test")]

mod example_323;
mod example_325;
mod example_326;
mod example_327;
mod example_328;
mod example_329;
mod example_330;
mod example_331;
mod example_332;
mod example_333;
mod example_334;
mod example_335;
mod example_336;
mod example_337;
mod example_338;
mod example_339;
mod example_340;
mod example_341;
mod example_342;
mod example_343;
mod example_344;
mod example_345;
mod example_346;
mod example_347;
mod exercise_17;
mod exercise_21;
mod exercise_31;
mod exercises_02_to_06;
mod exercises_32_and_33;
mod exercises_articulated;
mod exercises_cartesian;
mod exercises_planar_3r;
mod exercises_polar;
mod exercises_scara;
mod exercises_spherical;
mod support;
mod support_b;
