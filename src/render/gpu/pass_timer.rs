//! Measures the GPU time of each pass by timestamp queries.
//!
//! In: a device with timestamps, and the plan that was drawn. Out: the queries and buffers that the renderer encodes, and the milliseconds of each pass.

use super::GpuError;
use super::readback::read_mapped;
use crate::render::plan::Plan;
use wgpu::{Buffer, BufferDescriptor, BufferUsages, Device, QuerySet, QuerySetDescriptor, QueryType, Queue};

/// Maximum number of passes that are timed in a frame, which bounds the query set; later passes are not timed.
pub(super) const MAX_TIMED_PASSES: u32 = 32;
/// Bytes of the two timestamps of a pass, its begin and its end.
pub(super) const TIMESTAMP_PAIR_BYTES: u32 = 16;

/// Number of passes of the plan that are timed.
pub(super) fn timed_pass_count(plan: &Plan) -> u32 {
    (plan.passes.len() as u32).min(MAX_TIMED_PASSES)
}

/// Timestamp queries, two for each timed pass.
pub(super) struct PassTimer {
    pub queries: QuerySet,
    /// Receives the results of the queries, in GPU memory.
    pub results: Buffer,
    /// A copy of `results` that the CPU can map.
    pub readback: Buffer,
}

impl PassTimer {
    pub(crate) fn new(device: &Device) -> Self {
        let buffer = |usage| {
            device.create_buffer(&BufferDescriptor {
                label: Some("pass timer"),
                size: u64::from(TIMESTAMP_PAIR_BYTES * MAX_TIMED_PASSES),
                usage,
                mapped_at_creation: false,
            })
        };
        let queries = QuerySetDescriptor { label: Some("pass timer"), ty: QueryType::Timestamp, count: 2 * MAX_TIMED_PASSES };
        Self {
            queries: device.create_query_set(&queries),
            results: buffer(BufferUsages::QUERY_RESOLVE | BufferUsages::COPY_SRC),
            readback: buffer(BufferUsages::COPY_DST | BufferUsages::MAP_READ),
        }
    }

    /// Name and GPU milliseconds of each timed pass. `plan`: the plan that was drawn last.
    pub(crate) fn read(&self, device: &Device, queue: &Queue, plan: &Plan) -> Result<Vec<(String, f64)>, GpuError> {
        // The period is in nanoseconds.
        let tick_ms = f64::from(queue.get_timestamp_period()) * 1e-6;
        read_mapped(device, &self.readback, u64::from(TIMESTAMP_PAIR_BYTES * timed_pass_count(plan)), |bytes| {
            let ticks = bytes.as_chunks::<8>().0.iter().map(|b| u64::from_le_bytes(*b)).collect::<Vec<_>>();
            let durations_ms = ticks.chunks_exact(2).map(|t| tick_ms * t[1].saturating_sub(t[0]) as f64);
            plan.passes.iter().map(|p| p.name.to_owned()).zip(durations_ms).collect()
        })
    }
}
