//! Measured data: manifests, file formats, and their checks.
