"use strict";
// Draws a jaw on a canvas, from the side or from the front; lengths in mm, x forward, y to the left, z up.
const jaw = (() => {
  const scene = report.data.playback;
  const HEIGHT_MM = 164;
  const TURN = (9 * Math.PI) / 180;
  const cameras = {
    side: { right: [Math.cos(TURN), Math.sin(TURN)], toward: [Math.sin(TURN), -Math.cos(TURN)], at: 0.29 },
    front: { right: [0, 1], toward: [1, 0], at: 0.5 },
  };
  const bone = [[158, 140, 112], [252, 246, 231]];
  const tooth = [[176, 176, 172], [255, 255, 252]];
  const plate = [[52, 66, 82], [128, 146, 166]];
  const light = [-0.35, 0.62, 0.7];
  const root = getComputedStyle(document.documentElement);
  const css = (name) => root.getPropertyValue(name).trim();

  // Rotation matrix, by rows, of a rotation vector (Rodrigues).
  function rotation([x, y, z]) {
    const angle = Math.hypot(x, y, z);
    if (angle < 1e-9) return [1, 0, 0, 0, 1, 0, 0, 0, 1];
    const [a, b, c] = [x / angle, y / angle, z / angle];
    const [s, k] = [Math.sin(angle), 1 - Math.cos(angle)];
    return [1 - k * (b * b + c * c), k * a * b - s * c, k * a * c + s * b, k * a * b + s * c, 1 - k * (a * a + c * c), k * b * c - s * a, k * a * c - s * b, k * b * c + s * a, 1 - k * (a * a + b * b)];
  }

  const turned = (m, x, y, z) => [m[0] * x + m[1] * y + m[2] * z, m[3] * x + m[4] * y + m[5] * z, m[6] * x + m[7] * y + m[8] * z];
  const moved = (pose, p) => { const [x, y, z] = turned(pose.m, p[0], p[1], p[2]); return [x + pose.at[0], y + pose.at[1], z + pose.at[2]]; };
  const still = { m: rotation([0, 0, 0]), at: [0, 0, 0] };

  class View {
    constructor(canvas, name) {
      const size = canvas.clientWidth;
      const ratio = Math.min(devicePixelRatio || 1, 2);
      if (canvas.width !== Math.round(size * ratio)) canvas.width = canvas.height = Math.round(size * ratio);
      this.context = canvas.getContext("2d");
      this.context.setTransform(ratio, 0, 0, ratio, 0, 0);
      this.context.clearRect(0, 0, size, size);
      this.size = size;
      this.camera = cameras[name];
      this.scale = size / HEIGHT_MM;
    }

    point([x, y, z]) {
      const { right, at } = this.camera;
      return [(x * right[0] + y * right[1]) * this.scale + at * this.size, 0.285 * this.size - z * this.scale];
    }

    line(points, stroke, width, dash = []) {
      const { context } = this;
      context.beginPath();
      points.forEach((p, i) => context[i ? "lineTo" : "moveTo"](...this.point(p)));
      context.setLineDash(dash);
      context.lineWidth = width;
      context.strokeStyle = stroke;
      context.lineCap = "round";
      context.stroke();
      context.setLineDash([]);
    }

    fill(points, paint, stroke) {
      this.line([...points, points[0]], stroke, 1.2);
      this.context.fillStyle = paint;
      this.context.fill();
    }

    // Faces that look at the viewer, the far ones first, each in one shade.
    surface(mesh, pose, [shadow, bright]) {
      const { toward, right } = this.camera;
      const places = [];
      for (let i = 0; i < mesh.vertices.length; i += 3) places.push(moved(pose, [mesh.vertices[i] / 10, mesh.vertices[i + 1] / 10, mesh.vertices[i + 2] / 10]));
      const seen = places.map((p) => this.point(p));
      const depths = places.map((p) => p[0] * toward[0] + p[1] * toward[1]);
      const faces = [];
      for (let f = 0; f < mesh.faces.length / 4; f += 1) {
        const n = turned(pose.m, mesh.normals[3 * f] / 100, mesh.normals[3 * f + 1] / 100, mesh.normals[3 * f + 2] / 100);
        const facing = n[0] * toward[0] + n[1] * toward[1];
        if (facing <= 0) continue;
        let depth = 0;
        for (let k = 0; k < 4; k += 1) depth += depths[mesh.faces[4 * f + k]];
        const shade = Math.max(0, Math.min(1, 0.2 + 0.8 * ((n[0] * right[0] + n[1] * right[1]) * light[0] + n[2] * light[1] + facing * light[2])));
        faces.push([depth, f, shade]);
      }
      faces.sort((a, b) => a[0] - b[0]);
      const { context } = this;
      context.lineWidth = 0.7;
      for (const [, f, shade] of faces) {
        const paint = `rgb(${shadow.map((low, i) => Math.round(low + shade * (bright[i] - low))).join(",")})`;
        context.beginPath();
        for (let k = 0; k < 4; k += 1) context[k ? "lineTo" : "moveTo"](...seen[mesh.faces[4 * f + k]]);
        context.closePath();
        context.fillStyle = context.strokeStyle = paint;
        context.fill();
        context.stroke();
      }
    }

    text(words, x, y, align = "left", bold = false) {
      this.context.font = `${bold ? 600 : 400} 12px ${css("--font")}`;
      this.context.textAlign = align;
      this.context.fillStyle = css("--text");
      this.context.fillText(words, x, y);
    }
  }

  // From grey (unknown, sd of 50 %) to deep blue (known to 1 %).
  function knowledge(sd) {
    const share = Math.max(0, Math.min(1, Math.log(0.5 / sd) / Math.log(50)));
    const [from, to] = [[176, 150, 150], [20, 84, 170]];
    return `rgb(${from.map((low, i) => Math.round(low + share * (to[i] - low))).join(",")})`;
  }

  function muscles(view, motion, frame, pose, wanted) {
    motion.muscles.forEach((name, i) => {
      const side = name.endsWith("_left") ? "left" : name.endsWith("_right") ? "right" : "middle";
      if (!wanted.includes(side)) return;
      const sds = motion.parameters.flatMap((parameter, k) => (parameter.endsWith(`/${name}`) ? [frame.sd[k]] : []));
      view.line([motion.origin[i], moved(pose, motion.insertion[i])], knowledge(Math.max(...sds)), 3 + 2.2 * Math.sqrt(frame.tension[i]));
    });
  }

  function force(view, frame, from) {
    const size = Math.hypot(...frame.force);
    if (size < 0.2) return;
    const tip = from.map((x, i) => x + 3 * frame.force[i]);
    const [a, b] = [view.point(from), view.point(tip)];
    const length = Math.hypot(b[0] - a[0], b[1] - a[1]);
    view.line([from, tip], "#c92a2a", 3);
    if (length < 4) return;
    const [ux, uy] = [(b[0] - a[0]) / length, (b[1] - a[1]) / length];
    const { context } = view;
    context.beginPath();
    context.moveTo(b[0] + 6 * ux, b[1] + 6 * uy);
    context.lineTo(b[0] - 5 * uy - 4 * ux, b[1] + 5 * ux - 4 * uy);
    context.lineTo(b[0] + 5 * uy - 4 * ux, b[1] - 5 * ux - 4 * uy);
    context.fillStyle = "#c92a2a";
    context.fill();
  }

  const flat = (numbers, lift) => { const points = []; for (let i = 0; i < numbers.length; i += 2) points.push(lift(numbers[i], numbers[i + 1])); return points; };

  function path(view, motion, y) {
    const [drop, frequency] = motion.path;
    const points = [];
    for (let x = -3; x <= 25; x += 1) points.push([x, y, drop * (Math.cos(frequency * x) - 1)]);
    view.line(points, "#8a6f46", 3);
  }

  function draw(canvas, name, motion, frame) {
    const view = new View(canvas, name);
    const pose = { m: rotation(frame.turn), at: frame.contact };
    const held = moved(pose, motion.mouthpiece);
    const { surfaces, lines } = scene;
    const near = -scene.condyle_y;
    const skull = name === "side" ? flat(lines.head, (x, z) => [x, 0, z]) : flat(lines.face, (y, z) => [0, y, z]);
    view.fill(skull, css("--skull"), css("--skull-line"));
    if (name === "side") {
      view.fill(flat(lines.orbit, (x, z) => [x, 0, z]), css("--panel"), css("--skull-line"));
      muscles(view, motion, frame, pose, ["left"]);
    }
    view.surface(surfaces.mandible, pose, bone);
    view.surface(surfaces.lower_teeth, pose, tooth);
    view.surface(surfaces.upper_teeth, still, tooth);
    view.surface(surfaces.mouthpiece, { m: pose.m, at: held }, plate);
    muscles(view, motion, frame, pose, name === "side" ? ["right", "middle"] : ["left", "right", "middle"]);
    if (name === "side") {
      view.line(flat(lines.arch, (x, z) => [x, near, z]), css("--skull-line"), 1.4);
      path(view, motion, near);
      const [x, y] = view.point([frame.contact[0], near, frame.contact[2]]);
      view.context.beginPath();
      view.context.arc(x, y, 4, 0, 7);
      view.context.fillStyle = "#3b3f46";
      view.context.fill();
    } else {
      view.line([[0, 0, -20], [0, 0, -112]], css("--muted"), 1, [3, 4]);
      view.text("R", 6, view.size / 2);
      view.text("L", view.size - 6, view.size / 2, "right");
    }
    force(view, frame, held);
    view.text(name === "side" ? "from the right" : "from the front", 6, 16, "left", true);
  }

  const smooth = new Set(["contact", "turn", "moved"]);

  // The frame at a time: motions by a cubic through four frames, all else straight between two, commands held.
  function frameAt(motion, time) {
    const { frames } = motion;
    const times = frames.time_s;
    let i = times.findIndex((t) => t > time) - 1;
    if (i < 0) i = time < times[0] ? 0 : times.length - 1;
    const j = Math.min(i + 1, times.length - 1);
    const share = j > i ? (time - times[i]) / (times[j] - times[i]) : 0;
    const [h, k] = [Math.max(i - 1, 0), Math.min(j + 1, times.length - 1)];
    const between = (name, c) => {
      const [p, a, b, n] = [h, i, j, k].map((index) => frames[name][index][c]);
      if (!smooth.has(name)) return a + share * (b - a);
      return a + 0.5 * share * (b - p + share * (2 * p - 5 * a + 4 * b - n + share * (3 * (a - b) + n - p)));
    };
    const frame = { time_s: times[i], command: frames.command[i] };
    for (const name of ["contact", "turn", "moved", "tension", "force", "sd"]) frame[name] = frames[name][0].map((_, c) => between(name, c));
    return frame;
  }

  return { draw, frameAt, css };
})();
