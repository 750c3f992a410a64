// One or two runs on a time axis. The page holds their data as JSON under the id `viewer-data`:
//
// { runs: [{ name, robot, letter, period, ticks, stride,                       s; every `stride`-th tick is a row
//            joints: [{ name, position_unit, velocity_unit, torque_unit, effort, position: [low, high] | null, velocity, torque }],
//            chain: [{ slides, place }], tip,                                  3x4 by rows: parent_from_link at zero, link_from_tip
//            gravity: [x, y, z], payload: { mass, com } | null,                m/s^2 in base axes; kg and m in the tip frame
//            wrenches: [{ name, from, to, force, moment }],                    s, N and N m in tip axes, known or from outside
//            terms, thresholds, columns: { q, qd, error, qd_error, torque, ... }, tip_estimate,
//            events: [{ at, to, kind, joint, text }] }],
//   joint }                                                                    the joint shown first, counted from 0

import { Charts } from './charts.js';
import { Clock } from './clock.js';
import { decode } from './columns.js';
import { ofAll, ofJoint } from './curves.js';
import { element, onTheme } from './dom.js';
import { keys, player, readout } from './player.js';
import { Stage } from './scene.js';

const host = document.getElementById('viewer');
const data = JSON.parse(document.getElementById('viewer-data').textContent);
const runs = data.runs.map(decode);
const clock = new Clock(Math.max(...runs.map((run) => run.time[run.rows - 1])), Math.min(...runs.map((run) => run.step)));
const events = runs.flatMap((run) => run.events);

/** The stage, or words where there is no WebGL. */
function stage(box) {
  // Asked first: three would complain on the console.
  if (document.createElement('canvas').getContext('webgl2')) return new Stage(box, runs);
  box.classList.add('flat');
  box.append(element('p', {}, 'This browser draws no WebGL: the arm is not shown. Curves and tables are complete.'));
  return undefined;
}

const chips = element('div', { class: 'chips', role: 'group', 'aria-label': 'Joint shown' });
const curves = element('div', { class: 'curves' });
const scene = element('div', { class: 'scene' });
const charts = new Charts(curves, clock, events);
let chosen;

function choose(joint) {
  chosen = joint;
  const shown = joint < 0 ? ofAll(runs) : ofJoint(runs, joint).map((chart) => ({ ...chart, joint }));
  charts.show(shown);
  [...chips.children].forEach((chip, k) => chip.setAttribute('aria-pressed', k - 1 === joint));
}

['All joints', ...runs[0].joints.map((joint) => joint.name)].forEach((name, k) => {
  chips.append(element('button', { type: 'button', onclick: () => choose(k - 1) }, name));
});

const key = element('ul', { class: 'key' });
for (const [kind, name, there] of [
  ['c0', runs.length > 1 ? `tip of ${runs[0].letter}` : 'way of the tip', true],
  ['c1', `tip of ${runs[1]?.letter}`, runs.length > 1],
  ['gravity', `gravity ${Math.hypot(...runs[0].gravity).toFixed(2)} m/s\u00b2`, Math.hypot(...runs[0].gravity) > 0],
  ['payload', `payload ${runs[0].payload?.mass} kg`, runs[0].payload],
  ['contact', runs[0].wrenches.map((wrench) => `${wrench.name} ${Math.hypot(...wrench.force).toFixed(1)} N`).join(', '), runs[0].wrenches.length],
  ['estimate', 'force from outside, estimated', runs[0].wrench],
]) {
  if (there) key.append(element('li', { style: `--pen:var(--${kind})` }, name));
}

host.replaceChildren(
  element('div', { class: 'stage' }, scene, key, player(clock, events), readout(clock, runs)),
  element('div', { class: 'panel' }, chips, curves),
);
const arms = stage(scene);
if (arms) {
  clock.listen(() => arms.show(clock.t));
  const frames = element('input', { type: 'checkbox', onchange: () => arms.showFrames(frames.checked) });
  scene.append(element('div', { class: 'tools' },
    element('button', { type: 'button', onclick: () => arms.nextView(), title: 'v' }, 'View'),
    element('label', {}, frames, ' frames')));
}
clock.listen(() => (host.dataset.time = clock.t));
keys(clock, { joints: runs[0].joints.length, choose, charts, view: () => arms?.nextView() });
onTheme(() => choose(chosen));

// An address may name the moment and the joint: report.html#t=0.42&joint=2
const asked = new URLSearchParams(location.hash.slice(1));
choose(asked.has('joint') ? Number(asked.get('joint')) - 1 : data.joint);
clock.set(Number(asked.get('t') ?? 0));
host.dataset.ready = 'yes';
host.dataset.webgl = arms ? 'yes' : 'no';
// For whoever checks the drawing against the model: origin of the tip in the base frame, m.
globalThis.tipOfRun = (index) => arms?.arms[index].tipAt().toArray();
