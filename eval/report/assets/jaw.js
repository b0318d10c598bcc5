"use strict";
// Draws a jaw on a canvas, from the side or from the front, as jawenv.rendering does: shapes, cameras, colours and widths
// are its own (report.data.playback). Lengths in mm, x forward, y to the left, z up; widths in design units.
const jaw = (() => {
  const scene = report.data.playback;
  const { cameras, look, surfaces, lines } = scene;
  const LABELLED = 200; // px: below it a view is too small for words
  const [FAR, BEHIND, MIDDLE] = [0.5, 150 / 255, 190 / 255]; // how muscles fade that are far, behind bone, for both sides
  const root = getComputedStyle(document.documentElement);
  const css = (name) => root.getPropertyValue(name).trim();
  const parsed = (hex) => [1, 3, 5].map((i) => parseInt(hex.slice(i, i + 2), 16));
  const rgb = (colour, alpha = 1) => `rgba(${colour.map(Math.round).join(",")},${alpha})`;
  const mix = (a, b, share) => a.map((low, i) => low + share * (b[i] - low));

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
  const flat = (numbers, lift) => { const points = []; for (let i = 0; i < numbers.length; i += 2) points.push(lift(numbers[i], numbers[i + 1])); return points; };

  class View {
    constructor(canvas, name) {
      const size = canvas.clientWidth;
      const ratio = Math.min(devicePixelRatio || 1, 2);
      if (canvas.width !== Math.round(size * ratio)) canvas.width = canvas.height = Math.round(size * ratio);
      this.context = canvas.getContext("2d");
      this.context.setTransform(ratio, 0, 0, ratio, 0, 0);
      this.context.clearRect(0, 0, size, size);
      this.size = size;
      this.unit = size / look.design_height;
      this.camera = cameras[name];
      this.paper = parsed(css("--card"));
      this.ink = parsed(css("--text"));
    }

    point([x, y, z]) {
      const { right, origin, scale } = this.camera;
      return [((x * right[0] + y * right[1]) * scale + origin[0]) * this.size, (origin[1] - z * scale) * this.size];
    }

    path(pixels) {
      this.context.beginPath();
      pixels.forEach(([x, y], i) => this.context[i ? "lineTo" : "moveTo"](x, y));
    }

    stroke(pixels, paint, width, dash = []) {
      const { context } = this;
      this.path(pixels);
      context.setLineDash(dash);
      context.lineWidth = width * this.unit;
      context.strokeStyle = paint;
      context.lineCap = context.lineJoin = "round";
      context.stroke();
      context.setLineDash([]);
    }

    fill(pixels, paint) {
      this.path(pixels);
      this.context.fillStyle = paint;
      this.context.fill();
    }

    dot([x, y], radius, paint) {
      this.context.beginPath();
      this.context.arc(x, y, radius * this.unit, 0, 7);
      this.context.fillStyle = paint;
      this.context.fill();
    }

    line(points, paint, width, dash) { this.stroke(points.map((p) => this.point(p)), paint, width, dash); }

    outline(points, paint) {
      const pixels = points.map((p) => this.point(p));
      this.fill(pixels, paint);
      this.stroke([...pixels, pixels[0]], css("--skull-line"), 1.2);
    }

    // The skull dissolves at the top and at both sides.
    fade() {
      const { context, size } = this;
      const edge = 40 * this.unit;
      context.globalCompositeOperation = "destination-out";
      for (const [x, y] of [[0, edge], [0.6 * edge, 0], [-0.6 * edge, 0]]) {
        const gradient = context.createLinearGradient(x < 0 ? size : 0, 0, x < 0 ? size + x : x, y);
        gradient.addColorStop(0, "#000f");
        gradient.addColorStop(1, "#0000");
        context.fillStyle = gradient;
        context.fillRect(0, 0, size, size);
      }
      context.globalCompositeOperation = "source-over";
    }

    // The contour first, then the faces that look at the viewer, the far ones first, each in one shade. Of a half only
    // the faces on one side of the midline are drawn: 1 left, -1 right.
    surface(mesh, pose, [shadow, bright, contour], half = 0) {
      const { toward, right } = this.camera;
      const { light, ambient } = look;
      const places = [];
      for (let i = 0; i < mesh.vertices.length; i += 3) places.push(moved(pose, [mesh.vertices[i] / 10, mesh.vertices[i + 1] / 10, mesh.vertices[i + 2] / 10]));
      const seen = places.map((p) => this.point(p));
      const depths = places.map((p) => p[0] * toward[0] + p[1] * toward[1]);
      const [faces, facing] = [[], []];
      for (let f = 0; f < mesh.faces.length / 4; f += 1) {
        const n = turned(pose.m, mesh.normals[3 * f] / 100, mesh.normals[3 * f + 1] / 100, mesh.normals[3 * f + 2] / 100);
        facing.push(n[0] * toward[0] + n[1] * toward[1]);
        if (facing[f] <= 0 || (half && half * mesh.vertices[3 * mesh.faces[4 * f] + 1] < 0)) continue;
        let depth = 0;
        for (let k = 0; k < 4; k += 1) depth += depths[mesh.faces[4 * f + k]];
        const lit = (n[0] * right[0] + n[1] * right[1]) * light[0] + n[2] * light[1] + facing[f] * light[2];
        faces.push([depth, f, Math.max(0, Math.min(1, ambient + (1 - ambient) * lit))]);
      }
      const { context } = this;
      context.beginPath();
      for (let e = 0; e < mesh.edges.length; e += 4) {
        if (facing[mesh.edges[e + 2]] > 0 === facing[mesh.edges[e + 3]] > 0) continue;
        if (half && half * mesh.vertices[3 * mesh.edges[e] + 1] < 0) continue;
        context.moveTo(...seen[mesh.edges[e]]);
        context.lineTo(...seen[mesh.edges[e + 1]]);
      }
      context.lineWidth = 2 * this.unit;
      context.strokeStyle = rgb(contour);
      context.stroke();
      faces.sort((a, b) => a[0] - b[0]);
      context.lineWidth = 0.8;
      for (const [, f, shade] of faces) {
        context.beginPath();
        for (let k = 0; k < 4; k += 1) context[k ? "lineTo" : "moveTo"](...seen[mesh.faces[4 * f + k]]);
        context.closePath();
        context.fillStyle = context.strokeStyle = rgb(mix(shadow, bright, shade));
        context.fill();
        context.stroke();
      }
    }

    // A spindle, as wide as its tension asks, in the colour of what is known.
    muscle(from, to, width, colour, fade, alpha) {
      const [start, end] = [this.point(from), this.point(to)];
      const length = Math.max(Math.hypot(end[0] - start[0], end[1] - start[1]), 1e-6);
      const across = [-(end[1] - start[1]) / length, (end[0] - start[0]) / length];
      const edge = (half) => Array.from({ length: 17 }, (_, i) => {
        const out = half * this.unit * (0.4 + 0.6 * Math.sin((Math.PI * i) / 16) ** 0.8);
        return [0, 1].map((c) => start[c] + ((end[c] - start[c]) * i) / 16 + across[c] * out);
      });
      const body = mix(colour, this.paper, fade);
      const rim = mix(mix(colour, this.ink, 0.4), this.paper, fade);
      for (const [half, paint] of [[width / 2 + 0.9, rim], [width / 2, body]]) this.fill([...edge(half), ...edge(-half).reverse()], rgb(paint, alpha));
      if (alpha === 1 && width > 5) for (const lane of [-0.45, 0, 0.45]) this.stroke(edge((lane * width) / 2).slice(2, -2), rgb(mix(body, this.paper, 0.35)), 0.7);
      for (const end_ of [start, end]) this.dot(end_, Math.max(2.2, 0.26 * width), rgb(rim));
    }

    text(words, x, y, align = "left", bold = false) {
      this.context.font = `${bold ? 600 : 400} 12px ${css("--font")}`;
      this.context.textAlign = align;
      this.context.fillStyle = css("--text");
      this.context.fillText(words, x, y);
    }
  }

  // The colour of an sd, on a log scale from unknown to known.
  function knowledge(sd) {
    const [unknown, known] = look.known;
    const last = look.knowledge.length - 1;
    const place = Math.max(0, Math.min(1, Math.log(unknown / sd) / Math.log(unknown / known))) * last;
    const i = Math.min(Math.floor(place), last - 1);
    return mix(look.knowledge[i], look.knowledge[i + 1], place - i);
  }

  function muscles(view, motion, frame, pose, sides, layer, { fade = 0, alpha = 1 } = {}) {
    const [slack, perRoot, widest] = look.muscle;
    motion.muscles.forEach((name, i) => {
      if (!sides.includes(motion.sides[i]) || (layer && motion.layers[i] !== layer)) return;
      const sds = motion.parameters.flatMap((parameter, k) => (parameter.endsWith(`/${name}`) ? [frame.sd[k]] : []));
      const sd = Math.exp(sds.reduce((sum, each) => sum + Math.log(each), 0) / sds.length);
      const width = Math.min(slack + perRoot * Math.sqrt(Math.max(frame.tension[i], 0)), widest);
      view.muscle(motion.origin[i], moved(pose, motion.insertion[i]), width, knowledge(sd), fade, alpha);
    });
  }

  function force(view, pose, held, frame) {
    const [least, perN, longest] = look.force;
    const size = Math.hypot(...frame.force);
    if (size < least) return;
    const { right, toward, scale } = view.camera;
    const start = view.point(moved({ m: pose.m, at: held }, [9, 0, 0]));
    const across = [frame.force[0] * right[0] + frame.force[1] * right[1], -frame.force[2]];
    const shown = Math.hypot(...across);
    const [ink, paper] = [rgb(view.ink), rgb(view.paper)];
    let tip = start;
    if (shown > 0.3 * size) {
      const unit = across.map((each) => each / shown);
      const reach = Math.min(perN * shown, longest) * scale * view.size + 12 * view.unit;
      tip = start.map((each, c) => Math.max(12 * view.unit, Math.min(view.size - 12 * view.unit, each + unit[c] * reach)));
      const neck = tip.map((each, c) => each - unit[c] * 9 * view.unit);
      for (const [rim, paint] of [[1.4, paper], [0, ink]]) {
        const [wide, back] = [(5.5 + 1.7 * rim) * view.unit, neck.map((each, c) => each - unit[c] * rim * view.unit)];
        view.stroke([start, neck], paint, 3 + 2 * rim);
        view.fill([tip.map((each, c) => each + unit[c] * 2 * rim * view.unit), [back[0] - unit[1] * wide, back[1] + unit[0] * wide], [back[0] + unit[1] * wide, back[1] - unit[0] * wide]], paint);
      }
    } else {
      for (const [radius, paint] of [[9.5, paper], [8, ink], [6, paper]]) view.dot(start, radius, paint);
      const arm = 3.6 * view.unit;
      if (frame.force[0] * toward[0] + frame.force[1] * toward[1] > 0) view.dot(start, 2.6, ink);
      else for (const sign of [1, -1]) view.stroke([[start[0] - arm, start[1] - arm * sign], [start[0] + arm, start[1] + arm * sign]], ink, 1.8);
    }
    if (view.size < LABELLED) return;
    const below = tip === start || Math.abs(across[0]) > Math.abs(across[1]);
    const x = Math.max(26, Math.min(view.size - 26, tip[0] + (below ? 0 : (tip[0] + 62 < view.size ? 32 : -32))));
    const y = Math.min(view.size - 12, tip[1] + (below ? 22 : -4));
    view.fill([[x - 22, y - 10], [x + 22, y - 10], [x + 22, y + 8], [x - 22, y + 8]], rgb(view.paper, 0.85));
    view.text(`${size.toFixed(1)} N`, x, y + 4, "center", true);
  }

  const height = (motion, x) => motion.path[0] * (Math.cos(motion.path[1] * x) - 1);

  function side(view, motion, frame, pose, held) {
    const near = -scene.condyle_y;
    muscles(view, motion, frame, pose, ["left"], "", { fade: FAR });
    view.surface(surfaces.mandible, pose, look.bone, 1);
    view.surface(surfaces.lower_teeth, pose, look.tooth);
    view.surface(surfaces.mandible, pose, look.bone, -1);
    view.surface(surfaces.upper_teeth, still, look.tooth);
    view.surface(surfaces.mouthpiece, { m: pose.m, at: held }, look.plate);
    muscles(view, motion, frame, pose, ["right", "middle"], "inner", { alpha: BEHIND });
    muscles(view, motion, frame, pose, ["right", "middle"], "high");
    view.context.globalAlpha = 0.88;
    view.outline(flat(lines.arch, (x, z) => [x, near, z]), css("--skull"));
    view.context.globalAlpha = 1;
    muscles(view, motion, frame, pose, ["right", "middle"], "outer");
    view.line(Array.from({ length: 29 }, (_, i) => [i - 3, near, height(motion, i - 3)]), rgb(look.fossa), 3.6);
    const condyle = view.point([frame.contact[0], near, frame.contact[2]]);
    for (const [radius, paint] of [[4.4, view.paper], [3.2, view.ink]]) view.dot(condyle, radius, rgb(paint));
  }

  function front(view, motion, frame, pose, held) {
    muscles(view, motion, frame, pose, ["left", "right"], "high");
    view.surface(surfaces.mandible, pose, look.bone);
    view.surface(surfaces.lower_teeth, pose, look.tooth);
    muscles(view, motion, frame, pose, ["left", "right"], "inner", { alpha: BEHIND });
    view.surface(surfaces.upper_teeth, still, look.tooth);
    muscles(view, motion, frame, pose, ["left", "right"], "outer");
    muscles(view, motion, frame, pose, ["middle"], "", { alpha: MIDDLE });
    for (const sign of [1, -1]) {
      const roof = Array.from({ length: 13 }, (_, i) => [0, sign * scene.condyle_y + 1.4 * (i - 6), height(motion, frame.contact[0]) - 4.2 * (1 - Math.sqrt(1 - ((1.4 * (i - 6)) / 9.5) ** 2)) + 0.9]);
      view.line(roof, rgb(look.fossa), 3.6);
    }
    view.surface(surfaces.mouthpiece, { m: pose.m, at: held }, look.plate);
    view.line([[0, 0, -20], [0, 0, -112]], css("--muted"), 1, [3, 4]);
    view.text("R", 6, view.size / 2);
    view.text("L", view.size - 6, view.size / 2, "right");
  }

  function draw(canvas, name, motion, frame) {
    const view = new View(canvas, name);
    const pose = { m: rotation(frame.turn), at: frame.contact };
    const held = moved(pose, motion.mouthpiece);
    const seen = name === "side" ? (a, z) => [a, 0, z] : (a, z) => [0, a, z];
    view.outline(flat(name === "side" ? lines.head : lines.face, seen), css("--skull"));
    for (const hole of name === "side" ? [lines.orbit] : [...lines.orbits, lines.nose]) view.outline(flat(hole, seen), css("--card"));
    view.fade();
    (name === "side" ? side : front)(view, motion, frame, pose, held);
    force(view, pose, held, frame);
    view.text(name === "side" ? "from the right" : "from the front", 6, view.size - 6);
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
