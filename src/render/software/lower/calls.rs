//! Lowers calls by inlining every function at its call sites, except calls that become one native operation (`native.rs`).
//!
//! In: a function and its arguments. Out: the scalars of its result. Always: the callee's variables are removed from the environment when it returns.

use super::error::Result;
use super::lowerer::{CallFrame, Lowerer};
use super::ssa::SsaValue;
use super::value::Value;
use naga::valid::FunctionInfo;
use naga::{Expression, Function, Handle, Statement};
use rustc_hash::FxHashMap as HashMap;

impl<'m> Lowerer<'m> {
    /// Lowers the function of an entry point; returns the scalars of its result. `arguments`: the scalars of each argument.
    pub(crate) fn entry(&mut self, function: &'m Function, info: &'m FunctionInfo, arguments: Vec<Vec<SsaValue>>) -> Result<Vec<SsaValue>> {
        self.call(function, info, arguments.into_iter().map(Value::Scalars).collect())
    }

    /// Inlines a call; returns the scalars of its result.
    pub(crate) fn call(&mut self, function: &'m Function, info: &'m FunctionInfo, arguments: Vec<Value>) -> Result<Vec<SsaValue>> {
        // During the call, `env` ends with the flag that `return` sets, the scalars of the result, and the local variables.
        let return_flag = self.env.len();
        let no = self.builder.bool(false);
        self.env.push(no);
        let result_start = self.env.len();
        if let Some(r) = &function.result {
            let zeros = self.zeros(&self.module.types[r.ty].inner)?;
            self.env.extend(zeros);
        }
        let result_end = self.env.len();
        let mut frame = CallFrame {
            function,
            info,
            arguments,
            values: HashMap::default(),
            locals: HashMap::default(),
            return_flag,
            result_start,
            loop_flags: Vec::new(),
        };
        let mut initialisers = Vec::new();
        for (handle, local) in function.local_variables.iter() {
            self.span = function.local_variables.get_span(handle);
            frame.locals.insert(handle, self.env.len());
            if let Some(init) = local.init {
                initialisers.push((self.env.len(), init));
            }
            let zeros = self.zeros(&self.module.types[local.ty].inner)?;
            self.env.extend(zeros);
        }
        self.frames.push(frame);
        for (first, init) in initialisers {
            let values = self.scalars_of(init)?;
            self.env[first..first + values.len()].copy_from_slice(&values);
        }
        // Nothing in the callee leaves a loop of the caller.
        let caller_may_exit_by_jump = std::mem::replace(&mut self.may_exit_by_jump, false);
        self.block(&function.body)?;
        self.may_exit_by_jump = caller_may_exit_by_jump;
        // For the probe of a pixel, which shows the values of variables.
        self.capture_variables()?;
        self.frames.pop();
        let scalars = self.env[result_start..result_end].to_vec();
        self.env.truncate(return_flag);
        Ok(scalars)
    }

    /// Lowers a call statement, inlined or as a native operation, and records the value of its result if it has one.
    pub(crate) fn call_statement(
        &mut self,
        statement: &'m Statement,
        function: Handle<Function>,
        arguments: &[Handle<Expression>],
        result: Option<Handle<Expression>>,
    ) -> Result<()> {
        let callee = &self.module.functions[function];
        if let (Some(native), Some(r)) = (self.native_call(function, arguments)?, result) {
            return self.set_result(r, native);
        }
        let mut values = Vec::new();
        for a in arguments {
            values.push(self.value_of(*a)?);
        }
        let info = &self.info[function];
        let call_span = self.span;
        self.push_call_name(callee.name.as_deref(), statement);
        self.call_path.push(std::ptr::from_ref(statement).addr());
        let scalars = self.call(callee, info, values)?;
        self.call_path.pop();
        self.pop_call_name();
        self.span = call_span;
        result.map_or(Ok(()), |r| self.set_result(r, scalars))
    }

    /// Records the value of a call's result for the expressions that read it.
    fn set_result(&mut self, result: Handle<Expression>, scalars: Vec<SsaValue>) -> Result<()> {
        let value = Value::Scalars(scalars);
        self.capture_if_named(result, &value)?;
        self.frame_mut().values.insert(result, value);
        Ok(())
    }
}
