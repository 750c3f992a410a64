// Which curves stand in which chart: of one joint with reference, limits and terms, or of all joints over each other.

import { turn, colour } from './dom.js';

const TERMS = [
  ['inertia', 'inertia'], ['rotor', 'rotor'], ['coriolis', 'Coriolis and centrifugal'], ['gravity', 'gravity'],
  ['friction', 'friction'], ['contact', 'known contact'], ['rest', 'feedback and the rest'],
];

/** A curve of a run: its name, pen, unit, values, and where rows were left out the lowest and highest of each row. */
function curve(run, name, column, pen, unit) {
  return { run, name, pen, unit, at: column.at, low: column.low, high: column.high };
}

function sum(a, b) {
  return { at: a.at.map((x, k) => x + b.at[k]) };
}

/** A column up to the first fault: an arm that brakes follows no reference, and nobody estimates what pushes it. */
function driven(run, column) {
  if (run.driven >= run.rows) return column;
  return Object.fromEntries(Object.entries(column).map(([part, values]) => [part, values.map((x, k) => (k < run.driven ? x : NaN))]));
}

/** What the terms leave of the commanded torque. */
function rest(run, joint) {
  const known = TERMS.map(([key]) => run.columns[key]?.[joint]).filter(Boolean);
  return { at: run.columns.torque[joint].at.map((x, k) => known.reduce((left, term) => left - term.at[k], x)) };
}

/** A chart whose curves all have its unit. */
function alike(chart) {
  return { ...chart, curves: chart.curves.map((made) => ({ ...made, unit: chart.unit })) };
}

/** Charts of one joint. */
export function ofJoint(runs, joint) {
  const [first] = runs;
  const label = first.joints[joint];
  const pen = (index) => ({ stroke: turn(index), width: 1.5 });
  const each = (make) => runs.flatMap((run, index) => make(run, index, runs.length > 1 ? `${run.letter} ` : ''));
  const under = { stroke: colour('reference'), width: 4 };
  const position = {
    title: 'Position', unit: label.position_unit, limits: label.position,
    curves: [
      curve(first, 'reference', sum(first.columns.q[joint], first.columns.error[joint]), under),
      ...each((run, k, who) => curve(run, `${who}actual`, run.columns.q[joint], pen(k))),
    ],
  };
  const error = {
    title: 'Position error', unit: label.position_unit, zero: true,
    curves: each((run, k, who) => curve(run, `${who}reference less actual`, driven(run, run.columns.error[joint]), pen(k))),
  };
  const velocity = {
    title: 'Velocity', unit: label.velocity_unit, limits: label.velocity && [-label.velocity, label.velocity],
    curves: [
      curve(first, 'reference', sum(first.columns.qd[joint], first.columns.qd_error[joint]), under),
      ...each((run, k, who) => curve(run, `${who}actual`, run.columns.qd[joint], pen(k))),
    ],
  };
  const torque = {
    title: label.effort === 'force' ? 'Force' : 'Torque', unit: label.torque_unit,
    limits: label.torque && [-label.torque, label.torque],
    curves: each((run, k, who) => curve(run, `${who}commanded`, run.columns.torque[joint], pen(k))),
  };
  const terms = {
    title: `What the terms of the model contribute${runs.length > 1 ? ` (${first.letter})` : ''}`, unit: label.torque_unit, zero: true,
    curves: first.terms
      ? TERMS.map(([key, name], k) => {
          const column = key === 'rest' ? rest(first, joint) : first.columns[key]?.[joint];
          const grey = key === 'rest' ? { stroke: colour('faint'), width: 1 } : pen(k);
          return column && curve(first, name, column, grey);
        }).filter(Boolean)
      : [],
  };
  const external = {
    title: `${torque.title} from outside, estimated`, unit: label.torque_unit, zero: true,
    limits: first.thresholds && [-first.thresholds[joint], first.thresholds[joint]], bound: 'threshold',
    curves: each((run, k, who) => (run.columns.external ? [curve(run, `${who}external`, driven(run, run.columns.external[joint]), pen(k))] : [])),
  };
  return [position, error, velocity, torque, terms, external].filter((chart) => chart.curves.length).map(alike);
}

/** Charts of all joints, a colour each; a second run is dashed. Each curve keeps its joint's unit: a slide has others than a hinge. */
export function ofAll(runs) {
  const chart = (title, column, key, zero) => ({
    title, zero, unit: [...new Set(runs[0].joints.map((joint) => joint[key]))].join(', '),
    curves: runs.flatMap((run, index) =>
      (run.columns[column] ?? []).map((values, k) => {
        const name = `${runs.length > 1 ? `${run.letter} ` : ''}${run.joints[k].name}`;
        const pen = { stroke: turn(k), width: 1.5, dash: index ? [5, 4] : undefined };
        return curve(run, name, ['error', 'external'].includes(column) ? driven(run, values) : values, pen, run.joints[k][key]);
      })),
  });
  const efforts = new Set(runs[0].joints.map((joint) => joint.effort));
  const effort = efforts.size > 1 ? 'Torque or force' : efforts.has('force') ? 'Force' : 'Torque';
  return [
    chart('Position', 'q', 'position_unit'),
    chart('Position error', 'error', 'position_unit', true),
    chart('Velocity', 'qd', 'velocity_unit'),
    chart(effort, 'torque', 'torque_unit'),
    chart(`${effort} from outside, estimated`, 'external', 'torque_unit', true),
  ].filter((made) => made.curves.length);
}
