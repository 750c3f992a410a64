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
import { engineering } from './numbers.js';
import { keys, player, readout } from './player.js';
import { Stage } from './scene.js';

/** Show the runs of `data` in `host`. */
export function showRuns(host, data) {
  const runs = data.runs.map(decode);
  const clock = new Clock(Math.max(...runs.map((run) => run.time[run.rows - 1])), Math.min(...runs.map((run) => run.step)));
  // Of two runs, each event says whose it is.
  const events = runs.flatMap((run) => run.events.map((event) => (runs.length > 1 ? { ...event, text: `${run.letter}, ${event.text}` } : event)));

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
    ['c0', runs.length > 1 ? `tip of ${runs[0].letter}` : 'path of the tip', true],
    ['c1', `tip of ${runs[1]?.letter}`, runs.length > 1],
    ['gravity', `gravity ${Math.hypot(...runs[0].gravity).toFixed(2)} m/s\u00b2`, Math.hypot(...runs[0].gravity) > 0],
    ['payload', `payload ${runs[0].payload?.mass} kg`, runs[0].payload],
    ['contact', runs[0].wrenches.map((wrench) => `${wrench.name} ${Math.hypot(...wrench.force).toFixed(1)} N`).join(', '), runs[0].wrenches.length],
    ['estimate', 'force from outside, estimated', runs[0].wrench],
  ]) {
    if (there) key.append(element('li', { style: `--pen:var(--${kind})` }, name));
  }

  // What the marks on the curves mean, of those that this page has.
  const marks = element('p', { class: 'marks' });
  for (const [kind, name] of [
    ['waypoint', 'grey line: point of the motion'], ['push', 'shaded band: push'], ['fault', 'red line: fault'],
    ['reach', 'violet line: out of reach'], ['limit', 'stripe at the foot: a limit acts'],
  ]) {
    if (events.some((event) => event.kind === kind)) marks.append(element('span', { class: kind }, name));
  }

  /** The largest position error of all runs while their drives give torque: its size, time, joint and run. */
  function largestError() {
    let most = { size: 0, at: 0, joint: data.joint, run: runs[0] };
    for (const run of runs) {
      run.columns.error.forEach((column, joint) => {
        for (let row = 0; row < run.driven; row += 1) {
          const size = Math.abs(column.at[row]);
          if (size > most.size) most = { size, at: run.time[row], joint, run };
        }
      });
    }
    return most;
  }

  const worst = largestError();
  const { name: worstJoint, position_unit: worstUnit } = worst.run.joints[worst.joint];
  const found = element('p', { class: 'marks largest' }, element('a', { href: `#t=${worst.at}&joint=${worst.joint + 1}` },
    `largest position error${runs.length > 1 ? ` (${worst.run.letter})` : ''}: ${worstJoint}, ${engineering(worst.size, worstUnit)} at ${worst.at.toFixed(3)} s`));

  host.replaceChildren(
    element('div', { class: 'stage' }, scene, key, player(clock, events), readout(clock, runs)),
    element('div', { class: 'panel' }, chips, found, marks, curves),
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

  /** An address may name the moment and the joint: report.html#t=0.42&joint=2, where joint 0 is all of them. */
  function go(hash) {
    const asked = new URLSearchParams(hash.slice(1));
    const [t, joint] = ['t', 'joint'].map((name) => Number(asked.get(name) || NaN));
    if (Number.isInteger(joint) && joint >= 0 && joint <= runs[0].joints.length) choose(joint - 1);
    if (Number.isFinite(t)) clock.set(t);
  }
  // A report opens where a reader looks first.
  choose(worst.size > 0 ? worst.joint : data.joint);
  clock.set(worst.at);
  go(location.hash);
  addEventListener('hashchange', () => go(location.hash));
  // An event of the list: also a second time, when the address is already that one.
  addEventListener('click', (event) => {
    const link = event.target.closest?.('a[href^="#t="]');
    if (!link) return;
    go(link.hash);
    host.scrollIntoView({ block: 'nearest' });
  });
  host.dataset.ready = 'yes';
  host.dataset.webgl = arms ? 'yes' : 'no';
  // For whoever checks the drawing against the model: origin of the tip in the base frame, m; how faint an arm is; whether a force is guessed.
  globalThis.tipOfRun = (index) => arms?.arms[index].tipAt().toArray();
  globalThis.drawingOf = (index) => arms && { opacity: arms.arms[index].links.opacity, estimate: arms.arrows.estimate.visible };
}
