//! Composes robot, controller, reference and sensors into a run, and carries out its procedure.
