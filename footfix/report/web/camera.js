// The camera: an orbit about a target, and how the world falls on the canvas. Metres, y up.

const NEAR = 0.02;

class Camera {
  constructor(radius) {
    this.radius = radius; // of what is looked at
    this.yaw = 0.6;
    this.pitch = 0.2;
    this.distance = radius;
    this.target = [0, 0, 0];
    this.pan = [0, 0, 0]; // added to what is followed
  }

  orbit(yaw, pitch) {
    this.yaw += yaw;
    this.pitch = Math.max(-0.3, Math.min(Math.PI / 2 - 0.001, this.pitch + pitch));
  }

  zoom(factor) {
    this.distance = Math.max(this.radius * 0.15, Math.min(this.radius * 80, this.distance * factor));
  }

  /** Moves the target so that what is under the pointer goes along with it; dx, dy in pixels. */
  drag(dx, dy) {
    const scale = this.distance / this.focal;
    for (let k = 0; k < 3; k++) this.pan[k] += (-dx * this.right[k] + dy * this.up[k]) * scale;
  }

  /** Readies the projection for a canvas of this size in CSS pixels. */
  aim(width, height) {
    const [sy, cy] = [Math.sin(this.yaw), Math.cos(this.yaw)];
    const [sp, cp] = [Math.sin(this.pitch), Math.cos(this.pitch)];
    this.right = [cy, 0, -sy];
    this.up = [-sp * sy, cp, -sp * cy];
    this.back = [sy * cp, sp, cy * cp];
    this.eye = this.target.map((t, k) => t + this.pan[k] + this.distance * this.back[k]);
    this.focal = 1.7 * Math.min(height, width * 1.1);
    this.centre = [width / 2, height / 2];
  }

  depth(x, y, z) {
    return -((x - this.eye[0]) * this.back[0] + (y - this.eye[1]) * this.back[1] + (z - this.eye[2]) * this.back[2]);
  }

  /** [x, y, depth] on the canvas; null behind the eye. */
  project(x, y, z) {
    const depth = this.depth(x, y, z);
    if (depth < NEAR) return null;
    const [ex, ey, ez] = this.eye;
    const scale = this.focal / depth;
    const across = (x - ex) * this.right[0] + (z - ez) * this.right[2];
    const above = (x - ex) * this.up[0] + (y - ey) * this.up[1] + (z - ez) * this.up[2];
    return [this.centre[0] + scale * across, this.centre[1] - scale * above, depth];
  }

  /** Both ends of a segment on the canvas, cut at the near plane; null when all of it is behind. */
  segment(a, b) {
    const [da, db] = [this.depth(...a), this.depth(...b)];
    if (da < NEAR && db < NEAR) return null;
    const cut = (p, q, dp, dq) => {
      const u = (NEAR * 1.01 - dp) / (dq - dp);
      return p.map((value, k) => value + u * (q[k] - value));
    };
    const from = da < NEAR ? cut(a, b, da, db) : a;
    const to = db < NEAR ? cut(b, a, db, da) : b;
    const [pa, pb] = [this.project(...from), this.project(...to)];
    return pa && pb ? [pa, pb] : null;
  }
}
