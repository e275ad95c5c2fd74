//! Adds the named values of a module to the outputs of its program, for the probe of a pixel.
//!
//! In: a module and an entry point. Out: the entry point's program with one more output for each scalar of every named value. Named values are the values of
//! all `let` declarations, and the values of all variables when their function returns. Left out: arrays, and values with more than [`MAX_NAMED_SCALARS`]
//! scalars. Names in a called function are prefixed with the names of the called functions from the entry point on, each followed by a slash; where a function
//! contains several calls of another one, the second call's prefix ends in `name#2/`. In a loop the value of the last iteration is output. A value that the
//! pixel's control flow does not reach is NaN. Programs that draw images have none of these outputs.

use super::error::Result;
use super::lowerer::Lowerer;
use super::named_values::CapturedValue;
use super::ssa::{SsaInstr, SsaValue};
use super::value::Value;
use crate::render::software::tape::Op;
use naga::{Expression, Handle, ScalarKind, Statement, TypeInner};

/// Scalars of a 4x4 matrix.
const MAX_NAMED_SCALARS: usize = 16;

impl<'m> Lowerer<'m> {
    /// Appends a call to the path that prefixes names, which is kept only if named values were requested. `callee`: the function's name; one without a name is
    /// shown as `?`.
    pub(crate) fn push_call_name(&mut self, callee: Option<&str>, call: &'m Statement) {
        let Some(named_values) = &mut self.named_values else { return };
        let callee = callee.unwrap_or("?").to_owned();
        let call_sites = named_values.call_sites.entry((named_values.call_path.join("/"), callee.clone())).or_default();
        // The number counts call statements, not the times that one is lowered (in an unrolled loop, several). The address of a call statement identifies it,
        // since the module is borrowed during lowering.
        let call_site = std::ptr::from_ref(call).addr();
        let call_number = call_sites.iter().position(|s| *s == call_site).unwrap_or_else(|| {
            call_sites.push(call_site);
            call_sites.len() - 1
        });
        named_values.call_path.push(if call_number == 0 { callee } else { format!("{callee}#{}", call_number + 1) });
    }

    /// Removes the last call from the path that prefixes names.
    pub(crate) fn pop_call_name(&mut self) {
        if let Some(named_values) = &mut self.named_values {
            named_values.call_path.pop();
        }
    }

    /// For the probe of a pixel: captures an expression's value if a `let` gives it a name. Does nothing for pointers, textures and samplers, or if named
    /// values were not requested.
    pub(crate) fn capture_if_named(&mut self, handle: Handle<Expression>, value: &Value) -> Result<()> {
        let (Some(_), Value::Scalars(scalars)) = (&self.named_values, value) else { return Ok(()) };
        let frame = self.frame();
        let Some(name) = frame.function.named_expressions.get(&handle) else { return Ok(()) };
        let inner = frame.info[handle].ty.inner_with(&self.module.types).clone();
        self.capture_value(name.clone(), &inner, scalars)
    }

    /// For the probe of a pixel: captures the variables of the innermost function, which is about to return. Their scalars are in the environment (`env`).
    pub(crate) fn capture_variables(&mut self) -> Result<()> {
        if self.named_values.is_none() {
            return Ok(());
        }
        let function = self.frame().function;
        for (handle, local) in function.local_variables.iter() {
            let (Some(name), Some(first_in_env)) = (&local.name, self.frame().locals.get(&handle).copied()) else { continue };
            let inner = &self.module.types[local.ty].inner;
            let scalars = self.env[first_in_env..first_in_env + self.scalar_count(inner)?].to_vec();
            self.capture_value(name.clone(), inner, &scalars)?;
        }
        Ok(())
    }

    /// Converts a value to floats and assigns them to the outputs of its name, which are created when the name first gets a value. The members of a struct are
    /// captured one by one. Arrays have no `scalar_kind` and are skipped.
    fn capture_value(&mut self, name: String, inner: &TypeInner, scalars: &[SsaValue]) -> Result<()> {
        if let TypeInner::Struct { members, .. } = inner {
            let mut member_start = 0;
            for m in members {
                let member_type = &self.module.types[m.ty].inner;
                let count = self.scalar_count(member_type)?;
                self.capture_value(
                    format!("{name}.{}", m.name.as_deref().unwrap_or("?")),
                    member_type,
                    &scalars[member_start..member_start + count],
                )?;
                member_start += count;
            }
            return Ok(());
        }
        let Some(kind) = inner.scalar_kind().filter(|_| scalars.len() <= MAX_NAMED_SCALARS) else { return Ok(()) };
        let (one, zero) = (self.builder.float(1.0), self.builder.float(0.0));
        let numbers: Vec<SsaValue> = scalars
            .iter()
            .map(|v| match kind {
                ScalarKind::Bool => self.builder.select(*v, one, zero),
                ScalarKind::Sint => self.builder.unary(Op::FFromI, *v),
                ScalarKind::Uint => self.builder.unary(Op::FFromU, *v),
                _ => *v,
            })
            .collect();
        let new_variables: Vec<SsaValue> = numbers.iter().map(|_| self.builder.fresh_lane()).collect();
        let Some(named_values) = &mut self.named_values else { return Ok(()) };
        let name = named_values.call_path.iter().cloned().chain([name]).collect::<Vec<_>>().join("/");
        let index = *named_values.index_of.entry(name.clone()).or_insert_with(|| {
            named_values.captured.push(CapturedValue { name, output_variables: new_variables });
            named_values.captured.len() - 1
        });
        let output_variables = named_values.captured[index].output_variables.clone();
        for (dst, v) in output_variables.into_iter().zip(numbers) {
            // Inactive lanes keep the value that was captured before; initially NaN.
            let from = self.builder.select(self.active_mask, v, dst);
            self.builder.lane_instrs.push(SsaInstr::Assign { dst, from });
        }
        Ok(())
    }
}
