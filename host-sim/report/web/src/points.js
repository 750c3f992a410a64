// Points with a command: a press copies it, and says so.
addEventListener('click', (event) => {
  const point = event.target.closest?.('[data-command]');
  if (point) copy(point.dataset.command);
});
addEventListener('keydown', (event) => {
  const point = event.key === 'Enter' && document.activeElement?.closest?.('[data-command]');
  if (point) copy(point.dataset.command);
});

async function copy(text) {
  let words = `Copied: ${text}`;
  try {
    await navigator.clipboard.writeText(text);
  } catch {
    words = text;
  }
  const note = Object.assign(document.createElement('p'), { className: 'note', textContent: words });
  note.setAttribute('role', 'status');
  document.querySelector('.note')?.remove();
  document.body.append(note);
  setTimeout(() => note.remove(), 6000);
}
