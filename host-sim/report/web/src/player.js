// Play, pause, scrub, speed; the strip of events; and what every joint does now.

import { SPEEDS } from './clock.js';
import { isOver, rowAt } from './columns.js';
import { element } from './dom.js';
import { engineering } from './numbers.js';

function seconds(t, step) {
  return `${t.toFixed(step < 0.0095 ? 3 : 2)} s`;
}

/** Buttons, slider and speed. */
export function player(clock, events) {
  const play = element('button', { class: 'play', type: 'button', onclick: () => clock.toggle() }, 'Play');
  const scrub = element('input', {
    type: 'range', min: 0, max: clock.end, step: clock.step, value: 0, 'aria-label': 'Time', oninput: () => clock.set(Number(scrub.value)),
  });
  const now = element('output', { class: 'time' });
  const speed = element('select', { 'aria-label': 'Speed', onchange: () => clock.setSpeed(Number(speed.value)) },
    ...SPEEDS.map((x) => element('option', { value: x, selected: x === 1 }, `${x}\u00d7`)));
  const strip = element('div', { class: 'strip', 'aria-hidden': true });
  for (const event of events) {
    const left = (100 * event.at) / clock.end;
    const width = (100 * ((event.to ?? event.at) - event.at)) / clock.end;
    strip.append(element('i', { class: event.kind, style: `left:${left}%;width:${width}%`, title: event.text }));
  }
  clock.listen(() => {
    play.textContent = clock.playing ? 'Pause' : 'Play';
    scrub.value = clock.t;
    scrub.setAttribute('aria-valuetext', seconds(clock.t, clock.step));
    now.textContent = seconds(clock.t, clock.step);
    speed.value = clock.speed;
  });
  return element('div', { class: 'player' }, play, element('div', { class: 'track' }, scrub, strip), now, speed);
}

/** Table of the joints at the clock's time. */
export function readout(clock, runs) {
  const rows = runs[0].joints.flatMap((_, k) => runs.map((run) => ({ run, joint: run.joints[k], k })));
  const cells = rows.map(() => ['', '', '', ''].map(() => element('td')));
  const head = ['joint', 'position', 'error', 'torque', 'of limit'].map((name) => element('th', { scope: 'col' }, name));
  const body = rows.map(({ run, joint }, i) =>
    element('tr', {}, element('th', { scope: 'row' }, runs.length > 1 ? `${run.letter} ${joint.name}` : joint.name), ...cells[i]));
  clock.listen(() => {
    rows.forEach(({ run, joint, k }, i) => {
      if (isOver(run, clock.t)) {
        for (const cell of cells[i]) cell.textContent = '\u2013';
        cells[i][3].style.setProperty('--share', '0%');
        return;
      }
      const row = rowAt(run, clock.t);
      const { q, error, torque } = run.columns;
      const share = joint.torque ? Math.abs(torque[k].at[row]) / joint.torque : NaN;
      const [position, off, drive, of] = cells[i];
      position.textContent = `${q[k].at[row].toFixed(4)} ${joint.position_unit}`;
      off.textContent = engineering(row < run.driven ? error[k].at[row] : NaN, joint.position_unit);
      drive.textContent = engineering(torque[k].at[row], joint.torque_unit);
      of.textContent = Number.isFinite(share) ? `${(100 * share).toFixed(0)} %` : '\u2013';
      of.style.setProperty('--share', `${Math.min(100, 100 * (share || 0))}%`);
    });
  });
  return element('table', { class: 'readout' }, element('caption', {}, 'Joints at the cursor'),
    element('thead', {}, element('tr', {}, ...head)), element('tbody', {}, ...body));
}

/** Whether the element that has the focus wants a key for itself: a button its press, a list its choice, a table its scrolling. */
function wants(target, key) {
  if (target.type === 'range') return false;
  if (target.closest?.('button, summary, a, input[type="checkbox"]')) return key === ' ' || key === 'Enter';
  if (target.closest?.('.table, pre')) return /^(Arrow|Home$|End$)/.test(key);
  return Boolean(target.closest?.('input, select, textarea'));
}

/** Keys of the whole page, except where the focus wants them. */
export function keys(clock, { joints, choose, charts, view }) {
  addEventListener('keydown', (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || wants(event.target, event.key)) return;
    const far = event.shiftKey ? 10 : 1;
    const does = {
      ' ': () => clock.toggle(),
      ArrowLeft: () => clock.set(clock.t - far * clock.step),
      ArrowRight: () => clock.set(clock.t + far * clock.step),
      Home: () => clock.set(0),
      End: () => clock.set(clock.end),
      '+': () => charts.zoom(0.5),
      '=': () => charts.zoom(0.5),
      '-': () => charts.zoom(2),
      '<': () => clock.setSpeed(SPEEDS[Math.max(0, SPEEDS.indexOf(clock.speed) - 1)]),
      '>': () => clock.setSpeed(SPEEDS[Math.min(SPEEDS.length - 1, SPEEDS.indexOf(clock.speed) + 1)]),
      v: () => view(),
      a: () => choose(-1),
    }[event.key] ?? (/^[1-9]$/.test(event.key) && Number(event.key) <= joints ? () => choose(Number(event.key) - 1) : undefined);
    if (!does) return;
    event.preventDefault();
    does();
  });
}
