// What the player and the views of shapes have in common.
import * as THREE from 'three';

export const byId = id => document.getElementById(id);

/// The bytes that stand in the page as base64.
export function decode(text) {
  const binary = atob(text.trim()), bytes = new Uint8Array(binary.length);
  for (let i = 0; i < bytes.length; ++i) bytes[i] = binary.charCodeAt(i);
  return bytes.buffer;
}

/// Lights that stay with the camera.
export function addLights(scene, camera) {
  scene.add(new THREE.HemisphereLight(0xffffff, 0x6a6058, 0.9));
  const key = new THREE.DirectionalLight(0xfff6ea, 1.9), fill = new THREE.DirectionalLight(0xdfe8ff, 0.5);
  key.position.set(-0.6, 0.9, 0.8);
  fill.position.set(1, 0.1, 0.4);
  camera.add(key, fill);
  scene.add(camera);
}

/// Moves a camera back along its line of sight until it sees all points, with a margin. `forPoints`: calls a function with
/// each of them.
export function frameAll(forPoints, camera, target, towards) {
  camera.position.copy(target).add(towards);
  camera.lookAt(target);
  const up = Math.tan(camera.fov * Math.PI / 360) / 1.08, across = up * camera.aspect;
  const turn = camera.quaternion.clone().invert(), q = new THREE.Vector3();
  let distance = 0, behind = 0;
  forPoints(p => {
    q.copy(p).sub(target).applyQuaternion(turn);
    distance = Math.max(distance, q.z + Math.abs(q.x) / across, q.z + Math.abs(q.y) / up);
    behind = Math.max(behind, q.length());
  });
  camera.position.copy(target).addScaledVector(towards, distance);
  camera.near = distance / 100;
  camera.far = distance + 10 * behind;
  camera.updateProjectionMatrix();
}
