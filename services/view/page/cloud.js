// The point cloud, to turn with the mouse. Drawn when something changes, not all the time.

/* global THREE */

export class Cloud {
  constructor(pane) {
    this.pane = pane;
    this.points = 0;  // drawn
    this.colorBy = 'image';
    this.leastConfidence = 0;
    this.addTools();
    try {
      this.renderer = new THREE.WebGLRenderer({antialias: false, powerPreference: 'low-power'});
    } catch {
      const none = document.createElement('div');
      none.className = 'none';
      none.textContent = 'this browser has no WebGL: no cloud';
      pane.view.append(none);
      return;
    }
    this.renderer.setClearColor(0x0c0e10);
    pane.view.append(this.renderer.domElement);
    this.camera = new THREE.PerspectiveCamera(45, 1, 0.01, 1000);
    this.controls = new THREE.OrbitControls(this.camera, this.renderer.domElement);
    this.controls.enableKeys = false;  // arrows step through frames
    this.controls.screenSpacePanning = true;
    this.controls.addEventListener('change', () => this.render());
    this.geometry = new THREE.BufferGeometry();
    this.material = new THREE.PointsMaterial({size: 2, sizeAttenuation: false, vertexColors: THREE.VertexColors});
    const object = new THREE.Points(this.geometry, this.material);
    object.frustumCulled = false;
    this.scene = new THREE.Scene();
    this.scene.add(object);
    new ResizeObserver(() => this.resize()).observe(pane.view);
    pane.view.ondblclick = () => this.reset();
  }

  addTools() {
    const select = document.createElement('select');
    select.title = 'Colours of the points (C)';
    for (const name of ['image', 'depth', 'confidence']) select.append(new Option(name));
    select.onchange = () => { this.colorBy = select.value; this.show(); };
    this.select = select;
    const label = document.createElement('label');
    label.textContent = '≥';
    label.title = 'Hides points that are less sure: least probability of an error of at most 1 px';
    const slider = document.createElement('input');
    Object.assign(slider, {type: 'range', min: 0, max: 255, value: 0});
    slider.oninput = () => { this.leastConfidence = Number(slider.value); this.show(); };
    label.append(slider);
    this.pane.tools.prepend(select, label);
  }

  nextColors() {
    this.select.selectedIndex = (this.select.selectedIndex + 1) % this.select.length;
    this.select.onchange();
  }

  /// @param part  of a frame, or undefined: it has none.
  draw(part, scales, colors) {
    [this.part, this.scales, this.colors] = [part, scales, colors];
    this.show();
  }

  show() {
    if (!this.renderer || !this.part) {
      this.pane.note.textContent = this.renderer ? 'no cloud: needs left, disparity, calibration' : '';
      if (this.geometry) this.geometry.setDrawRange(0, 0);
      this.points = 0;
      return this.render();
    }
    this.fill();
    if (!this.placed) this.reset();
    this.pane.note.textContent = `${this.points.toLocaleString('en')} points`;
    this.render();
  }

  // Points from the grid of disparities: z = f·b / (d + cx_right − cx). three.js looks along −z, y up.
  fill() {
    const part = this.part;
    const total = part.columns * part.rows;
    const counts = new Int16Array(part.buffer, part.start, total);
    const rgb = new Uint8Array(part.buffer, part.start + 2 * total, 3 * total);
    const confidence = part.has_confidence ? new Uint8Array(part.buffer, part.start + 5 * total, total) : undefined;
    this.reserve(total);
    const [positions, paint] = [this.positions.array, this.paint.array];
    const depths = [];
    let n = 0;
    for (let i = 0; i < total; ++i) {
      if (counts[i] === part.invalid) continue;
      const sure = confidence ? confidence[i] : 255;
      if (sure < this.leastConfidence) continue;
      const z = part.focal_px * part.baseline_m / (counts[i] / part.counts_per_px + part.cx_right - part.cx);
      if (!(z > 0 && z < 1e4)) continue;
      const u = i % part.columns * part.stride;
      const v = Math.floor(i / part.columns) * part.stride;
      positions[3 * n] = (u - part.cx) * z / part.focal_px;
      positions[3 * n + 1] = -(v - part.cy) * z / part.focal_px;
      positions[3 * n + 2] = -z;
      if (i % 61 === 0) depths.push(z);
      paint.set(this.colorOf(rgb.subarray(3 * i, 3 * i + 3), z, sure), 3 * n);
      ++n;
    }
    this.points = n;
    this.median = depths.sort((a, b) => a - b)[depths.length >> 1] ?? 1;
    this.geometry.setDrawRange(0, n);
    this.positions.needsUpdate = this.paint.needsUpdate = true;
  }

  colorOf(rgb, z, sure) {
    if (this.colorBy === 'depth') return this.colors.of(z, this.scales.depth);
    return this.colorBy === 'confidence' ? [sure, sure, sure] : rgb;
  }

  reserve(total) {
    if (this.capacity >= total) return;
    this.capacity = total;
    this.positions = new THREE.BufferAttribute(new Float32Array(3 * total), 3);
    this.paint = new THREE.BufferAttribute(new Uint8Array(3 * total), 3, true);
    for (const attribute of [this.positions, this.paint]) attribute.setUsage?.(THREE.DynamicDrawUsage);
    this.geometry.setAttribute('position', this.positions);
    this.geometry.setAttribute('color', this.paint);
  }

  /// The camera beside and above the left one, so that one sees at a glance whether surfaces are flat.
  reset() {
    if (!this.renderer || !this.part) return;
    this.placed = true;
    const {part, median} = this;
    const rows = part.rows * part.stride;
    this.camera.fov = 2 * Math.atan(rows / 2 / part.focal_px) * 180 / Math.PI;
    this.controls.target.set(0, 0, -median);
    this.camera.position.set(0.42 * median, 0.3 * median, 0.08 * median);
    this.controls.update();
    this.resize();
  }

  resize() {
    const {clientWidth: width, clientHeight: height} = this.pane.view;
    if (!this.renderer || !width || !height) return;
    this.renderer.setPixelRatio(devicePixelRatio);
    this.renderer.setSize(width, height);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.render();
  }

  render() {
    if (!this.renderer || !this.pane.view.clientWidth) return;
    if (this.part) {
      // Makes points as large as the gaps between them.
      const away = this.camera.position.distanceTo(this.controls.target) / (this.median ?? 1);
      const pixel = this.pane.view.clientHeight * devicePixelRatio / this.part.rows;
      this.material.size = Math.max(1, Math.min(8, Math.ceil(pixel / away)));
    }
    this.renderer.render(this.scene, this.camera);
  }
}
