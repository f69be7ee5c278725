// The panes: a picture each, its colour scale, a cross at the pixel of interest.

import {drawSeeds} from './seeds.js';

const kPanes = [
  {name: 'left', title: 'Left image', seeds: true},
  {name: 'disparity', title: 'Disparity', scale: 'disparity'},
  {name: 'cloud', title: 'Point cloud'},
  {name: 'tof', title: 'ToF depth', scale: 'depth', pixels: true},
  {name: 'prior', title: 'Prior', scale: 'disparity'},
  {name: 'confidence', title: 'Confidence', scale: 'confidence'},
];
const kSigmas = {
  prior: {picture: 'sigma', title: 'Standard deviation of the prior'},
  confidence: {picture: 'disparity_sigma', title: 'Standard deviation of the disparity'},
};
const kMissing = {
  left: 'no left image', disparity: 'no disparity map', tof: 'no ToF image', prior: 'no prior',
  confidence: 'no confidence: grow { publish_confidence: true }', fused: 'no fused map: sprout-temporal does not run',
};

const make = (tag, className, parent) => {
  const element = document.createElement(tag);
  element.className = className;
  parent.append(element);
  return element;
};

/// Colours of a scale from its smallest value to its largest one, as the server paints them.
export class Colors {
  constructor(hex) {
    this.rgb = hex.match(/.{6}/g).map((text) => [0, 2, 4].map((i) => parseInt(text.substr(i, 2), 16)));
  }

  /// [r, g, b] of a value.
  of(value, scale) {
    // Depths are coloured by 1/depth, as disparities are, so that one surface has one colour.
    const isDepth = scale.near === 'min';
    const at = (x) => (isDepth ? 1 / x : x);
    const [far, near] = isDepth ? [scale.max, scale.min] : [scale.min, scale.max];
    const share = Math.min(1, Math.max(0, (at(value) - at(far)) / (at(near) - at(far))));
    return this.rgb[Math.round(share * 255)];
  }
}

const grey = {of: (value) => Array(3).fill(Math.round(255 * value))};

export class Panes {
  /// hover(u, v) is called for the pixel under the mouse, hover() when it leaves.
  constructor(root, hover, changed) {
    this.root = root;
    this.panes = new Map();
    this.changed = changed;  // what is to be seen is another
    this.depth = false;
    this.sigma = {prior: false, confidence: false};  // shown in the place of these
    this.fused = false;  // shown in the prior's place, beside the single disparity map
    this.seeds = true;
    for (const [i, spec] of kPanes.entries()) this.add(spec, i, hover);
    this.addTools();
    new ResizeObserver(() => changed()).observe(root);
  }

  add(spec, i, hover) {
    const element = make('section', `pane ${spec.name}`, this.root);
    const heading = make('h2', '', element);
    const title = make('span', '', heading);
    title.textContent = spec.title;
    const note = make('small', '', heading);
    const tools = make('span', 'tools', heading);
    const view = make('div', spec.pixels ? 'view pixels' : 'view', element);
    const pane = {spec, element, title, note, tools, view};
    this.panes.set(spec.name, pane);
    const big = make('button', '', tools);
    big.textContent = '⤢';
    big.title = `Large or small (${i + 1})`;
    big.onclick = () => this.enlarge(i);
    if (spec.name === 'cloud') return;
    pane.picture = make('canvas', 'picture', view);
    if (spec.seeds) pane.seeds = make('canvas', 'seeds', view);
    pane.mark = make('canvas', 'mark', view);
    pane.none = make('div', 'none', view);
    view.onmousemove = (event) => {
      const pixel = this.pixelAt(pane, event);
      pixel ? hover(...pixel) : hover();
    };
    view.onmouseleave = () => hover();
    view.ondblclick = () => this.enlarge(i);
    this.addDrawing(pane, view);
    if (spec.scale) {
      const scale = make('div', 'scale', element);
      pane.scale = {low: make('span', '', scale), bar: make('canvas', '', scale), high: make('span', '', scale)};
    }
  }

  addTools() {
    for (const [name, title] of [['prior', 'Its standard deviation (P)'],
                                 ['confidence', 'Standard deviation of the disparity (O)']]) {
      const {tools} = this.panes.get(name);
      const button = make('button', '', tools);
      button.onclick = () => this.toggleSigma(name);
      button.textContent = 'σ';
      button.title = title;
      tools.prepend(button);  // large or small stays the last one
    }
    const left = this.panes.get('left');
    this.seedsButton = make('button', '', left.tools);
    this.seedsButton.onclick = () => this.toggleSeeds();
    this.seedsButton.textContent = 'hide';
    this.seedsButton.title = 'Seeds on the image (E)';
    const fused = make('button', '', this.panes.get('prior').tools);
    fused.onclick = () => this.toggleFused();
    fused.textContent = 'fused';
    fused.title = 'The map fused with earlier frames (F)';
    this.panes.get('prior').tools.prepend(fused);
    left.tools.prepend(this.seedsButton);
  }

  toggleSigma(name) {
    this.sigma[name] = !this.sigma[name];
    if (name === 'prior') this.fused = false;
    const {title, spec} = this.panes.get(name);
    title.textContent = this.sigma[name] ? kSigmas[name].title : spec.title;
    this.changed();
  }

  toggleFused() {
    this.fused = !this.fused;
    this.sigma.prior = false;
    this.nameFused();
    this.changed();
  }

  nameFused() {
    const {title, spec} = this.panes.get('prior');
    title.textContent = !this.fused ? spec.title : this.depth ? 'Fused depth' : 'Fused disparity';
  }

  toggleSeeds() {
    this.seeds = !this.seeds;
    this.panes.get('left').seeds.hidden = !this.seeds;
    this.seedsButton.textContent = this.seeds ? 'hide' : 'seeds';
    this.changed();
  }

  setDepth(depth) {
    this.depth = depth;
    this.panes.get('disparity').title.textContent = depth ? 'Depth' : 'Disparity';
    if (this.fused) this.nameFused();
    this.changed();
  }

  /// Shows one pane large, or all again.
  enlarge(i) {
    const pane = i === undefined ? undefined : this.panes.get(kPanes[i].name);
    const again = !pane || pane.element.classList.contains('big');
    for (const {element} of this.panes.values()) element.classList.remove('big');
    this.root.classList.toggle('one', !again);
    if (!again) pane.element.classList.add('big');
    this.changed();
  }

  isShown(name) {
    return this.panes.get(name).element.offsetParent !== null;
  }

  /// What the server calls the picture of a pane.
  pictureOf(name) {
    if (name === 'disparity' && this.depth) return 'depth';
    if (name === 'prior' && this.fused) return this.depth ? 'fused_depth' : 'fused';
    return this.sigma[name] ? kSigmas[name].picture : name;
  }

  /// What to ask the server for: pictures as wide as they are shown, in steps that windows of
  /// nearly the same size share.
  wish() {
    const pictures = {};
    for (const [name, {view}] of this.panes) {
      if (name === 'cloud' || !this.isShown(name)) continue;
      const width = view.clientWidth * devicePixelRatio;
      pictures[this.pictureOf(name)] = Math.max(64, Math.ceil(width / 64) * 64);
    }
    return {pictures, seeds: this.seeds && this.isShown('left'), cloud: this.isShown('cloud')};
  }

  async draw(head, colors) {
    this.size = [head.width, head.height];
    const byName = new Map(head.parts.map((part) => [part.name, part]));
    await Promise.all([...this.panes.values()].map((pane) => this.drawPane(pane, head, byName, colors)));
    const seeds = byName.get('seeds');
    const {note, seeds: canvas} = this.panes.get('left');
    if (seeds && this.seeds && head.width > 0) {
      drawSeeds(canvas, seeds, this.size, head.scales.disparity, colors);
      note.textContent = `${seeds.tof + seeds.stereo} seeds`;
      note.title = `${seeds.tof} seeds of the ToF camera, ${seeds.stereo} of stereo; ` +
          `${seeds.left_only} points that the left camera sees alone`;
    } else {
      note.textContent = '';
      canvas.getContext('2d').clearRect(0, 0, canvas.width, canvas.height);
    }
  }

  async drawPane(pane, head, byName, colors) {
    const name = pane.spec.name;
    if (name === 'cloud' || !this.isShown(name)) return;
    const what = this.pictureOf(name);
    const part = byName.get(what);
    pane.none.textContent = part ? '' : kMissing[what.startsWith('fused') ? 'fused' : name];
    if (!part) {
      pane.picture.width = pane.picture.height = 1;
      pane.full = undefined;
      pane.note.textContent = '';
      return;
    }
    const bytes = new Uint8Array(part.buffer, part.start, part.size);
    const bitmap = await createImageBitmap(new Blob([bytes], {type: 'image/jpeg'}));
    if (pane.picture.width !== bitmap.width) pane.picture.width = bitmap.width;
    if (pane.picture.height !== bitmap.height) pane.picture.height = bitmap.height;
    pane.picture.getContext('2d').drawImage(bitmap, 0, 0);
    bitmap.close();
    pane.full = [part.full_width, part.full_height];
    if (name !== 'left') pane.note.textContent = `${part.full_width} × ${part.full_height}`;
    const scaleName = {depth: 'depth', fused_depth: 'depth', sigma: 'sigma', disparity_sigma: 'sigma'}[what] ?? pane.spec.scale;
    if (scaleName) drawScale(pane.scale, head.scales[scaleName], scaleName === 'confidence' ? grey : colors);
  }

  /// Where a picture is inside its view: [x, y, width, height] in CSS pixels.
  frameOf(pane) {
    const [width, height] = [pane.view.clientWidth, pane.view.clientHeight];
    const {width: columns, height: rows} = pane.picture;
    const scale = Math.min(width / columns, height / rows);
    return [(width - columns * scale) / 2, (height - rows * scale) / 2, columns * scale, rows * scale];
  }

  // The pixel of the left image under the mouse, or the one next to it; the ToF camera has pixels of
  // its own.
  pixelAt(pane, event, nearest = false) {
    if (!pane.full || pane.spec.pixels || !this.size?.[0]) return undefined;
    const [x, y, width, height] = this.frameOf(pane);
    const box = pane.view.getBoundingClientRect();
    const u = Math.floor((event.clientX - box.left - x) / width * this.size[0]);
    const v = Math.floor((event.clientY - box.top - y) / height * this.size[1]);
    if (nearest) {
      return [[u, 0], [v, 1]].map(([at, i]) => Math.min(this.size[i] - 1, Math.max(0, at)));
    }
    return u >= 0 && v >= 0 && u < this.size[0] && v < this.size[1] ? [u, v] : undefined;
  }

  // Lets the mouse draw a rectangle while onRect() has a function.
  addDrawing(pane, view) {
    let from;
    const rectTo = (event) => {
      const to = this.pixelAt(pane, event, true);
      const [left, top] = [0, 1].map((i) => Math.min(from[i], to[i]));
      return [left, top, Math.abs(to[0] - from[0]) + 1, Math.abs(to[1] - from[1]) + 1];
    };
    view.onpointerdown = (event) => {
      from = this.onRect && event.button === 0 ? this.pixelAt(pane, event) : undefined;
      if (from) view.setPointerCapture(event.pointerId);
    };
    view.onpointermove = (event) => {
      if (!from || !this.onRect) return;
      this.drawing = rectTo(event);
      this.redraw();
    };
    view.onpointerup = view.onpointercancel = (event) => {
      this.drawing = undefined;
      // A click is no rectangle.
      const rect = from && this.onRect && event.type === 'pointerup' ? rectTo(event) : undefined;
      from = undefined;
      if (rect && rect[2] > 4 && rect[3] > 4) this.onRect(rect, event.shiftKey);
      this.redraw();
    };
  }

  /// onRect([left, top, width, height] in pixels of the left image, whether Shift was down) is
  /// called for each rectangle that is drawn from now on; without it the mouse draws none.
  drawRect(onRect) {
    this.onRect = onRect;
  }

  /// Rectangles to show in every picture.
  setRects(rects) {
    this.rects = rects;
    this.redraw();
  }

  /// A cross at a pixel in every picture, or none.
  mark(pixel) {
    this.pixel = pixel;
    this.redraw();
  }

  redraw() {
    const rects = [...this.rects ?? [], ...(this.drawing ? [this.drawing] : [])];
    for (const pane of this.panes.values()) {
      if (!pane.mark) continue;
      const canvas = pane.mark;
      [canvas.width, canvas.height] = [pane.view.clientWidth, pane.view.clientHeight];
      if (!pane.full || pane.spec.pixels) continue;
      const [x, y, width, height] = this.frameOf(pane);
      const context = canvas.getContext('2d');
      const [sx, sy] = [width / this.size[0], height / this.size[1]];
      for (const [left, top, columns, rows] of rects) {
        for (const [color, line] of [['#000a', 4], ['#fff', 1.5]]) {
          context.strokeStyle = color;
          context.lineWidth = line;
          context.strokeRect(x + left * sx, y + top * sy, columns * sx, rows * sy);
        }
      }
      if (!this.pixel) continue;
      const cu = x + (this.pixel[0] + 0.5) * sx;
      const cv = y + (this.pixel[1] + 0.5) * sy;
      for (const [color, line] of [['#000a', 3], ['#fff', 1]]) {
        context.strokeStyle = color;
        context.lineWidth = line;
        context.beginPath();
        for (const [du, dv] of [[1, 0], [-1, 0], [0, 1], [0, -1]]) {
          context.moveTo(cu + 4 * du, cv + 4 * dv);
          context.lineTo(cu + 12 * du, cv + 12 * dv);
        }
        context.stroke();
      }
    }
  }
}

function drawScale({low, bar, high}, scale, colors) {
  const span = scale.max - scale.min;
  const text = (value) => `${value.toFixed(span < 1 ? 2 : span < 20 ? 1 : 0)} ${scale.unit}`;
  [low.textContent, high.textContent] = [text(scale.min), text(scale.max)];
  [bar.width, bar.height] = [256, 1];
  const context = bar.getContext('2d');
  const image = context.createImageData(256, 1);
  for (let i = 0; i < 256; ++i) {
    const value = scale.min + (scale.max - scale.min) * i / 255;
    image.data.set([...colors.of(value, scale), 255], 4 * i);
  }
  context.putImageData(image, 0, 0);
}
