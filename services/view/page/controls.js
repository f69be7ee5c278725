// Buttons and keys.

// Files that can be saved, with the messages that a frame must have for each.
const kFiles = {
  'left.png': ['LEFT'], 'right.png': ['RIGHT'], 'disparity.png': ['DISPARITY'], 'prior.png': ['PRIOR'],
  'confidence.png': ['CONFIDENCE'], 'disparity.pfm': ['DISPARITY'], 'prior.pfm': ['PRIOR'], 'sigma.pfm': ['SIGMA'],
  'cloud.ply': ['DISPARITY', 'LEFT', 'RIG'],
};
const kKeys = [
  ['Space', 'stop and look, or go on'], ['← →', 'one frame back or on; with Shift ten'],
  ['Home, End', 'the first frame, the newest one'], ['1 … 6', 'one pane large, or all again'],
  ['D', 'disparity or depth'], ['E', 'seeds on the left image'], ['P', 'prior or its standard deviation'],
  ['O', 'confidence or the standard deviation of the disparity'],
  ['F', 'prior or the map fused with earlier frames'],
  ['M', 'how good depth is on a flat target'],
  ['C', 'colours of the cloud'], ['R', 'the cloud as it was'], ['S', 'save this frame, or the last seconds'],
  ['?', 'these keys'],
];

const byId = (id) => document.getElementById(id);

/// @param app  with toggle(), step(n), first(), newest(), key, head, isLog, panes, cloud, target, toggleUnit().
export function addControls(app) {
  const saveBox = byId('save-box');
  const helpBox = byId('help-box');
  const save = () => {
    const channels = app.head?.channels ?? [];
    const files = Object.keys(kFiles).filter((file) => kFiles[file].every((name) => channels.includes(`SPROUT_${name}`)));
    byId('save-frame').replaceChildren(...files.map((file) => {
      const link = document.createElement('a');
      link.href = `save?key=${app.key}&what=${file}`;
      link.download = '';
      link.textContent = file;
      return link;
    }));
    byId('save-log').hidden = app.isLog;
    saveBox.showModal();
  };
  byId('save-log').onsubmit = () => { location.href = `save-log?seconds=${Math.round(byId('seconds').value)}`; };
  for (const [keys, text] of kKeys) {
    const row = byId('keys').insertRow();
    const key = document.createElement('kbd');
    key.textContent = keys;
    row.insertCell().append(key);
    row.insertCell().textContent = text;
  }
  for (const close of document.querySelectorAll('dialog .close')) close.onclick = () => close.closest('dialog').close();

  byId('pause').onclick = () => app.toggle();
  byId('back').onclick = () => app.step(-1);
  byId('forward').onclick = () => app.step(1);
  byId('unit').onclick = () => app.toggleUnit();
  byId('save').onclick = save;
  byId('help').onclick = () => helpBox.showModal();

  const actions = {
    ' ': () => app.toggle(), 'ArrowLeft': (event) => app.step(event.shiftKey ? -10 : -1),
    'ArrowRight': (event) => app.step(event.shiftKey ? 10 : 1), 'Home': () => app.first(),
    'End': () => app.newest(), 'd': () => app.toggleUnit(), 'e': () => app.panes.toggleSeeds(),
    'f': () => app.panes.toggleFused(), 'p': () => app.panes.toggleSigma('prior'), 'o': () => app.panes.toggleSigma('confidence'),
    'c': () => app.cloud.nextColors(), 'r': () => app.cloud.reset(),
    'm': () => app.target.toggle(),
    's': save, '?': () => helpBox.showModal(), 'Escape': () => app.panes.enlarge(),
  };
  addEventListener('keydown', (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || saveBox.open || helpBox.open) return;
    const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
    const slider = event.target.matches?.('#slider');
    if (event.target.matches?.('input:not(#slider), select') || (event.key === ' ' && event.target.matches?.('button'))) return;
    if (/^[1-6]$/.test(key)) app.panes.enlarge(Number(key) - 1);
    else if (actions[key]) actions[key](event);
    else return;
    if (slider) event.target.blur();
    event.preventDefault();
  });
}
