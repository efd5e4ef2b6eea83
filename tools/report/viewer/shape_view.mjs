// One shape in 3D, with marks on it that are buttons over the picture.
import * as THREE from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';
import { addLights, frameAll } from './stage.mjs';
import { ALONE, colourOf, meetingColours, ownColours } from './pick_data.mjs';
import { length, minus } from './surface.mjs';

const CLICK = 5;  // pixels that a pointer may move between down and up in a click
const STEP = 10 * Math.PI / 180, NEARER = 0.85;
const KEYS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
const BUTTONS = [['turnLeft', '\u25c0', 'turn left', v => v.turn(-1, 0)], ['turnRight', '\u25b6', 'turn right', v => v.turn(1, 0)],
  ['turnUp', '\u25b2', 'turn up', v => v.turn(0, -1)], ['turnDown', '\u25bc', 'turn down', v => v.turn(0, 1)],
  ['nearer', '+', 'nearer', v => v.zoom(NEARER)], ['farther', '\u2212', 'farther', v => v.zoom(1 / NEARER)],
  ['whole', '\u2302', 'show it whole', v => v.showWhole()]];

export function element(tag, properties = {}, children = []) {
  const made = Object.assign(document.createElement(tag), properties);
  made.append(...children);
  return made;
}

export class ShapeView {
  /// `act`: what the page does: picked(view, hit), hovered(view, hit or null), moved(view), markMoved(mark, hit, done),
  /// markKey(mark, event), markChosen(mark). Throws where the browser shows no WebGL.
  constructor(data, index, act) {
    this.data = data, this.index = index, this.act = act, this.shape = data.shapes[index];
    this.canvas = element('canvas', { tabIndex: 0 });
    this.canvas.setAttribute('role', 'application');
    this.canvas.setAttribute('aria-label', this.shape.short + ' in 3D. Arrow keys turn it, with shift they move it, plus and ' +
      'minus zoom, 0 shows it whole, enter puts a place at the cross in the middle.');
    this.marks = element('div', { className: 'marks' });
    const tools = BUTTONS.map(([name, sign, what, action]) => {
      const button = element('button', { type: 'button', textContent: sign, title: what, className: name, onclick: () => action(this) });
      button.setAttribute('aria-label', this.shape.short + ': ' + what);
      return button;
    });
    this.holder = element('div', { className: 'holder' }, [this.canvas, this.marks]);
    this.node = element('figure', { className: 'shape' }, [element('figcaption', {}, [element('b', { textContent: this.shape.short }),
      element('span', { className: 'tools' }, tools)]), this.holder]);
    this.renderer = new THREE.WebGLRenderer({ canvas: this.canvas, antialias: true, alpha: true, preserveDrawingBuffer: true });
    this.renderer.setPixelRatio(window.devicePixelRatio);
    this.scene = new THREE.Scene();
    this.camera = new THREE.PerspectiveCamera(28, 1, 0.01, 100);
    this.camera.up.set(...data.up);
    addLights(this.scene, this.camera);
    this.addMesh();
    this.addLimbs();
    this.listen();
    new ResizeObserver(() => this.resize()).observe(this.holder);
  }

  /// World coordinates of the input, as numbers in a list, to those of the scene, whose middle is the shape's origin.
  local(place) { return minus(place, this.shape.origin); }

  addMesh() {
    this.geometry = new THREE.BufferGeometry();
    this.geometry.setAttribute('position', new THREE.BufferAttribute(this.shape.surface.points, 3));
    this.geometry.setIndex(new THREE.BufferAttribute(this.shape.surface.triangles, 1));
    this.geometry.computeVertexNormals();
    this.scene.add(new THREE.Mesh(this.geometry, new THREE.MeshStandardMaterial({ vertexColors: true, roughness: 0.7, metalness: 0 })));
  }

  /// `kind`: 'meeting' (where it lands), 'own' or 'clay'.
  paint(kind) {
    const colours = kind === 'meeting' ? meetingColours(this.data, this.index) : ownColours(this.shape, kind === 'clay');
    this.geometry.setAttribute('color', new THREE.BufferAttribute(colours, 3));
    this.draw();
  }

  /// A line that is seen through the surface, with a rim that sets it off.
  addLine(points, colour, thickness, group) {
    const curve = new THREE.CatmullRomCurve3(points.map(p => new THREE.Vector3(...this.local(p))));
    for (const [shade, wide, order] of [['#ffffff', 1.9, 1], [colour, 1, 2]]) {
      const material = new THREE.MeshBasicMaterial({ color: shade, depthTest: false, transparent: true, opacity: order === 1 ? 0.75 : 1 });
      const parts = [new THREE.TubeGeometry(curve, 40, thickness * wide, 8)];
      for (const end of [points[0], points[points.length - 1]])
        parts.push(new THREE.SphereGeometry(thickness * (end === points[0] ? 1 : 2.2) + thickness * (wide - 1), 16, 12).translate(...this.local(end)));
      for (const part of parts) {
        const mesh = new THREE.Mesh(part, material);
        mesh.renderOrder = order;
        group.add(mesh);
      }
    }
  }

  addLimbs() {
    this.limbs = new THREE.Group();
    const thin = 0.0045 * this.shape.size;
    for (const limb of this.shape.limbs) this.addLine(limb.line, limb.group < 0 ? ALONE : colourOf(limb.group), thin, this.limbs);
    this.data.features.filter(f => f.kind === 'line').forEach(f => this.addLine(f.positions[this.index], '#1d2126', thin, this.limbs));
    this.scene.add(this.limbs);
  }

  listen() {
    this.controls = new OrbitControls(this.camera, this.canvas);
    this.controls.addEventListener('change', () => this.draw());
    this.controls.addEventListener('start', () => this.act.moved(this));
    this.controls.addEventListener('change', () => this.act.moved(this));
    let down = null;
    this.canvas.addEventListener('pointerdown', e => { down = e.isPrimary && e.button === 0 ? e : null; });
    this.canvas.addEventListener('pointerup', e => {
      if (!down || Math.hypot(e.clientX - down.clientX, e.clientY - down.clientY) > CLICK) return;
      down = null;
      const hit = this.hitAt(e.clientX, e.clientY);
      if (hit) this.act.picked(this, hit);
    });
    this.canvas.addEventListener('pointermove', e => {
      if (!e.buttons && e.pointerType !== 'touch') this.act.hovered(this, this.hitAt(e.clientX, e.clientY));
    });
    this.canvas.addEventListener('pointerleave', () => this.act.hovered(this, null));
    this.canvas.addEventListener('keydown', e => this.key(e));
  }

  key(event) {
    const step = KEYS[event.key];
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (step && event.shiftKey) this.pan(...step);
    else if (step) this.turn(...step);
    else if (event.key === '+' || event.key === '=') this.zoom(NEARER);
    else if (event.key === '-') this.zoom(1 / NEARER);
    else if (event.key === '0') this.showWhole();
    else if (event.key === 'Enter' || event.key === ' ') {
      const box = this.canvas.getBoundingClientRect();
      const hit = this.hitAt(box.x + box.width / 2, box.y + box.height / 2);
      if (hit) this.act.picked(this, hit);
    } else return;
    event.preventDefault();
  }

  /// Turns the shape as seen, by steps.
  turn(right, down) {
    const { camera, controls } = this, offset = camera.position.clone().sub(controls.target);
    const side = new THREE.Vector3().crossVectors(camera.up, offset).normalize(), tilt = offset.angleTo(camera.up);
    const wanted = Math.min(Math.max(tilt - down * STEP, 0.05), Math.PI - 0.05);
    offset.applyAxisAngle(side, wanted - tilt).applyAxisAngle(camera.up, right * STEP);
    camera.position.copy(controls.target).add(offset);
    controls.update();
  }

  zoom(factor) {
    this.camera.position.lerpVectors(this.controls.target, this.camera.position, factor);
    this.controls.update();
  }

  pan(right, down) {
    const move = new THREE.Vector3(-right, down, 0).multiplyScalar(0.05 * this.shape.size).applyQuaternion(this.camera.quaternion);
    this.camera.position.add(move);
    this.controls.target.add(move);
    this.controls.update();
  }

  /// Looks from the direction in which another view looks.
  lookAs(view) {
    const towards = view.camera.position.clone().sub(view.controls.target).normalize();
    this.camera.position.copy(this.controls.target).addScaledVector(towards, this.camera.position.distanceTo(this.controls.target));
    this.controls.update();
  }

  /// Towards the camera: across the longer one of the level sides, so that head and tail are seen, and from a little above.
  firstDirection() {
    const up = this.data.up.findIndex(x => x !== 0), [a, b] = [[1, 2], [0, 2], [0, 1]][up], { sides } = this.shape;
    const [along, through] = sides[b] > 1.1 * sides[a] ? [b, a] : [a, b], towards = [0, 0, 0];
    towards[along] = 0.45, towards[through] = up === 2 && through === 1 ? -1 : 1, towards[up] = 0.3;
    return new THREE.Vector3(...towards).normalize();
  }

  showWhole() {
    const { lowest, sides, surface } = this.shape;
    this.controls.target.set(...lowest.map((low, d) => low + sides[d] / 2));
    const towards = this.firstDirection();
    const p = new THREE.Vector3();
    frameAll(visit => {
      for (let i = 0; i < surface.points.length; i += 3) visit(p.fromArray(surface.points, i));
    }, this.camera, this.controls.target, towards);
    this.controls.update();
    this.draw();
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.holder;
    if (!width || !height) return;
    const first = !this.sized;
    this.sized = true;
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    if (first) this.showWhole();
    this.draw();
  }

  /// What is seen at a place of the window: a hit of the surface, with its place in the input's coordinates; null: nothing.
  hitAt(x, y) {
    const box = this.canvas.getBoundingClientRect(), eye = this.camera.position;
    const through = new THREE.Vector3((x - box.x) / box.width * 2 - 1, 1 - (y - box.y) / box.height * 2, 0.5).unproject(this.camera);
    const direction = through.sub(eye).normalize().toArray();
    const hit = this.shape.surface.cast(eye.toArray(), direction);
    if (hit) hit.place = this.shape.surface.at(hit).map((c, d) => c + this.shape.origin[d]);
    return hit;
  }

  /// Where a place is on the canvas, pixels, and whether the surface hides it.
  seen(place) {
    const at = this.local(place), p = new THREE.Vector3(...at).project(this.camera);
    const eye = this.camera.position.toArray(), way = minus(at, eye), far = length(way);
    const hit = this.shape.surface.cast(eye, way.map(c => c / far));
    return { x: (p.x + 1) / 2 * this.holder.clientWidth, y: (1 - p.y) / 2 * this.holder.clientHeight,
      behind: !!hit && hit.distance < far - 0.02 * this.shape.size };
  }

  /// `marks`: {key, text, colour, place, kind, label, chosen}; those of kind 'place' can be dragged. Buttons stay for as
  /// long as their key does, so that they keep focus and pointer.
  show(marks) {
    this.shown = marks;
    const old = new Map([...this.marks.children].map(node => [node.dataset.key, node]));
    for (const mark of marks) {
      let node = old.get(mark.key);
      old.delete(mark.key);
      if (!node) this.marks.append(node = this.markNode(mark));
      node.mark = mark;
      node.textContent = mark.text;
      node.title = mark.label;
      node.className = 'mark ' + mark.kind + (mark.chosen ? ' chosen' : '');
      node.style.setProperty('--colour', mark.colour);
      if (mark.kind === 'place') node.setAttribute('aria-label', mark.label);
    }
    for (const node of old.values()) node.remove();
    this.placeMarks();
  }

  markNode(mark) {
    const node = element(mark.kind === 'place' ? 'button' : 'span');
    node.dataset.key = mark.key;
    if (mark.kind !== 'place') return node;
    node.type = 'button';
    node.addEventListener('pointerdown', e => {
      if (e.button !== 0) return;
      node.setPointerCapture(e.pointerId);
      node.drag = { x: e.clientX, y: e.clientY, moved: false };
      this.act.markChosen(node.mark);
    });
    node.addEventListener('pointermove', e => {
      if (!node.drag || !node.hasPointerCapture(e.pointerId)) return;
      if (!node.drag.moved && Math.hypot(e.clientX - node.drag.x, e.clientY - node.drag.y) < 3) return;
      node.drag.moved = true;
      const hit = this.hitAt(e.clientX, e.clientY);
      if (hit) this.act.markMoved(node.mark, hit, false);
    });
    const end = e => {
      const moved = node.drag && node.drag.moved;
      node.drag = null;
      if (moved) this.act.markMoved(node.mark, e.type === 'pointerup' ? this.hitAt(e.clientX, e.clientY) : null, true);
    };
    node.addEventListener('pointerup', end);
    node.addEventListener('pointercancel', end);
    node.addEventListener('keydown', e => this.markKey(node, e));
    node.addEventListener('focus', () => this.act.markChosen(node.mark));
    return node;
  }

  /// Arrow keys move a mark along the surface by pixels.
  markKey(node, event) {
    const step = KEYS[event.key];
    if (!step) return this.act.markKey(node.mark, event);
    event.preventDefault();
    const box = this.canvas.getBoundingClientRect(), at = this.seen(node.mark.place), by = event.shiftKey ? 16 : 4;
    const hit = this.hitAt(box.x + at.x + by * step[0], box.y + at.y + by * step[1]);
    if (hit) this.act.markMoved(node.mark, hit, true);
  }

  placeMarks() {
    for (const node of this.marks.children) {
      const { x, y, behind } = this.seen(node.mark.place);
      node.style.transform = `translate(${x}px, ${y}px) translate(-50%, -50%)`;
      node.classList.toggle('behind', behind);
    }
  }

  /// Marks at once, the picture once for all that changes before the next frame of the screen.
  draw() {
    if (!this.sized) return;
    this.placeMarks();
    if (this.waits) return;
    this.waits = requestAnimationFrame(() => {
      this.waits = 0;
      this.renderer.render(this.scene, this.camera);
    });
  }
}
