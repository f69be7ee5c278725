// Values at the pixel under the mouse. One pixel is asked for at a time, the newest.

const text = (value, digits, unit) =>
  value === undefined ? '–' : `${value.toFixed(digits)}${unit ? ` ${unit}` : ''}`;

const spread = (value, sigma) =>
  sigma === undefined ? text(value, 2, 'px') : `${value.toFixed(2)} ± ${sigma.toFixed(2)} px`;

export class Hover {
  constructor(root, panes, connection) {
    [this.root, this.panes, this.connection] = [root, panes, connection];
    this.hint = root.innerHTML;
  }

  /// Called when the mouse is at another pixel, or at none.
  at(u, v) {
    this.pixel = u === undefined ? undefined : [u, v];
    this.panes.mark(this.pixel);
    if (this.pixel) this.ask();
  }

  /// Called when another frame is shown.
  ask() {
    if (!this.pixel) return;
    this.panes.mark(this.pixel);
    this.connection().send({type: 'probe', u: this.pixel[0], v: this.pixel[1]});
  }

  show(probe) {
    const facts = [
      ['u, v', `${probe.u}, ${probe.v}`],
      ['disparity', spread(probe.disparity_px, probe.disparity_sigma_px)],
      ['depth', text(probe.depth_m, 3, 'm')],
      ['confidence', text(probe.confidence, 2)],
      ['prior', spread(probe.prior_px, probe.sigma_px)],
    ];
    if (probe.fused_px !== undefined) facts.push(['fused', text(probe.fused_px, 2, 'px')]);
    const seed = probe.seed;
    if (seed) {
      facts.push(['nearest seed', `${seed.origin}, ${seed.distance_px.toFixed(1)} px away`]);
      facts.push(['its disparity', `${seed.disparity_px.toFixed(2)} ± ${seed.sigma_px.toFixed(2)} px`]);
    }
    this.root.replaceChildren(...facts.map(([name, value]) => {
      const span = document.createElement('span');
      const label = document.createElement('small');
      label.textContent = `${name} `;
      const number = document.createElement('b');
      number.textContent = value;
      span.append(label, number);
      return span;
    }));
    this.shown = probe;
  }
}
