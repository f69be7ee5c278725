// How good depth is on a flat target: a region that is drawn with the mouse, and the figures beside
// it, as sprout-quality has them.

const byId = (id) => document.getElementById(id);

export class Target {
  constructor(panes, connection) {
    [this.panes, this.connection] = [panes, connection];
    this.on = false;
    byId('measure').onclick = () => this.toggle();
    byId('target-close').onclick = () => this.toggle();
    byId('target-distance').onchange = () => this.ask();
  }

  toggle() {
    this.on = !this.on;
    byId('target').hidden = !this.on;
    byId('measure').setAttribute('aria-pressed', this.on);
    [this.region, this.edge, this.shown] = [undefined, undefined, undefined];
    byId('target-figures').replaceChildren();
    byId('target-note').textContent = '';
    // While it is on, the mouse draws the region, with Shift the edge.
    this.panes.drawRect(this.on ? (rect, isEdge) => this.drawn(rect, isEdge) : undefined);
    this.panes.setRects([]);
    if (this.on) this.ask();
    else this.connection().send({type: 'measure', off: true});
  }

  /// Called when a rectangle was drawn.
  drawn(rect, isEdge) {
    if (isEdge) this.edge = rect;
    else this.region = rect;
    this.ask();
  }

  /// Says what to measure: from now on, and when another server answers.
  ask() {
    if (!this.on) return;
    const message = {type: 'measure'};
    if (this.region) message.region = this.region;
    if (this.edge) message.edge = this.edge;
    const distance = byId('target-distance').valueAsNumber;
    if (distance > 0 && distance <= 10000) message.distance_m = distance;
    this.connection().send(message);
  }

  show(answer) {
    if (!this.on) return;
    this.shown = answer;
    if (answer.region) this.panes.setRects([answer.region, answer.edge].filter(Boolean));
    byId('target-note').textContent =
        answer.error ?? `${answer.frames} frame${answer.frames === 1 ? '' : 's'}, ${answer.region.join(', ')} px`;
    byId('target-note').classList.toggle('bad', answer.error !== undefined);
    const table = byId('target-figures');
    table.replaceChildren();
    for (const {name, title, text, meaning} of answer.figures ?? []) {
      const row = table.insertRow();
      row.title = meaning;
      row.dataset.name = name;
      row.insertCell().textContent = title;
      row.insertCell().textContent = text;
    }
  }
}
