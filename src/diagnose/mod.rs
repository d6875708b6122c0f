//! What the simulation gets wrong: residual, candidates, selection, extension, gain.
