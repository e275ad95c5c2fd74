//! Why a plan could not be executed, and allocations that return such an error if memory is insufficient.

use super::MAX_SIDE_PX;

/// Why a plan could not be executed. Each message is one line that states the error, the draw or pass if it concerns one, and a remedy if there is one.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum RenderError {
    #[error("pass {pass}: {width}x{height} pixels; each side must be 1 to {MAX_SIDE_PX}")]
    Size { pass: String, width: u32, height: u32 },
    #[error("pass {pass}: {samples} samples per pixel; 1 and 4 are possible")]
    Samples { pass: String, samples: u8 },
    #[error("not enough memory for {what} ({bytes} bytes); reduce the image size")]
    Memory { what: &'static str, bytes: u128 },
    #[error("draw {draw}: the fragment stage reads location {location} (component {component}), which the vertex stage does not write")]
    Varying { draw: String, location: u32, component: u32 },
    #[error("draw {draw}: the vertex stage writes no position")]
    NoPosition { draw: String },
    #[error("draw {draw}: the vertex stage reads attribute {location}, which the draw does not supply")]
    Attribute { draw: String, location: u32 },
    #[error("draw {draw}: attribute {location} has fewer values than the {count} instances need")]
    Instances { draw: String, location: u32, count: u32 },
    #[error("draw {draw}: index {index} is outside the mesh's {vertices} vertices")]
    Index { draw: String, index: u32, vertices: usize },
    #[error("draw {draw}: the module reads binding {binding}, which the draw does not supply")]
    Binding { draw: String, binding: u32 },
    #[error("draw {draw}: binding {binding} reads pass {pass}, which is not an earlier pass")]
    PassOrder { draw: String, binding: u32, pass: usize },
    #[error("draw {draw}: the texture at binding {binding} cannot be read: {what}")]
    Texture { draw: String, binding: u32, what: String },
    #[error("draw {draw}: {what}")]
    Module { draw: String, what: String },
    #[error(
        "draw {draw}: a loop of the {stage} stage was stopped, because it does not end or takes too long; limit its number of iterations"
    )]
    LoopLimit { draw: String, stage: &'static str },
    #[error("the plan has no pass")]
    NoPass,
    #[error("this machine lacks the instruction set of the {0} kernels")]
    Kernels(String),
    #[error("the renderer's threads could not be started: {0}")]
    Threads(String),
}

/// A vector of `count` values; returns an error instead of aborting if memory is insufficient. `what` names the data in the error.
pub(crate) fn try_vec<T: Clone>(count: usize, value: T, what: &'static str) -> Result<Vec<T>, RenderError> {
    let mut vec = Vec::new();
    if vec.try_reserve_exact(count).is_err() {
        return Err(RenderError::Memory { what, bytes: count as u128 * size_of::<T>() as u128 });
    }
    vec.resize(count, value);
    Ok(vec)
}

/// Reserves memory for `more` values; returns an error instead of aborting if memory is insufficient. `what` names the data in the error.
pub(crate) fn try_grow<T>(vec: &mut Vec<T>, more: usize, what: &'static str) -> Result<(), RenderError> {
    let bytes = (vec.len() as u128 + more as u128) * size_of::<T>() as u128;
    vec.try_reserve(more).map_err(|_| RenderError::Memory { what, bytes })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn too_much_memory_is_an_error_and_not_an_abort() {
        let mut values = vec![1_u64];
        assert_eq!(try_grow(&mut values, 7, "a test"), Ok(()));
        assert!(values.capacity() >= 8);
        let error = try_grow(&mut values, usize::MAX / 16, "a test").expect_err("more than can be allocated");
        assert!(error.to_string().contains("not enough memory for a test"), "{error}");
        assert!(try_vec(usize::MAX, 0_u64, "a test").is_err());
    }
}
