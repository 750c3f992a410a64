// Columns of a run: base64 of little-endian f32, one value a row.

function floats(text) {
  const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  return new Float32Array(bytes.buffer);
}

/** A run whose columns are decoded; row k is tick `k * stride`, as it was; from row `driven` on a fault has taken the drives away. */
export function decode(run) {
  const columns = {};
  for (const [name, joints] of Object.entries(run.columns)) {
    columns[name] = joints.map((column) =>
      Object.fromEntries(Object.entries(column).map(([part, text]) => [part, floats(text)])),
    );
  }
  const rows = columns.q[0].at.length;
  const step = run.stride * run.period;
  const time = Float64Array.from({ length: rows }, (_, k) => k * step);
  const wrench = run.tip_estimate?.map(floats);
  const fault = run.events.find((event) => event.kind === 'fault');
  const driven = fault ? Math.ceil(fault.at / step - 1e-6) : rows;
  return { ...run, columns, rows, step, time, wrench, driven };
}

/** Row in force at `t` (s). */
export function rowAt(run, t) {
  return Math.max(0, Math.min(run.rows - 1, Math.floor(t / run.step + 1e-6)));
}

/** Whether the run is over at `t` (s): its last row is in force until the next would be due. */
export function isOver(run, t) {
  return Math.floor(t / run.step + 1e-6) >= run.rows;
}

/** Values for a chart, where NaN is a gap. */
export function gaps(values) {
  return Array.from(values, (x) => (Number.isFinite(x) ? x : null));
}
