"use strict";
(() => {
  const data = JSON.parse(document.getElementById("data").textContent);
  const { summary, scans, links } = data;
  const byId = (id) => document.getElementById(id);
  const SVG = "http://www.w3.org/2000/svg";
  const number = (value, digits) => (value === null || value === undefined ? "" : value.toFixed(digits));
  const hue = (i) => `hsl(${(216 + 222.5 * i) % 360} 60% 42%)`;
  const grade = (mm) => (mm < 10 ? "good" : mm < 30 ? "fair" : "bad");
  const element = (parent, name, text) => {
    const node = document.createElement(name);
    if (text !== undefined) node.textContent = text;
    parent.appendChild(node);
    return node;
  };

  byId("headline").textContent = `${summary.command} · version ${summary.version}`;
  const figure = (value, label) => {
    const box = element(byId("figures"), "div");
    box.className = "figure";
    element(box, "b", value);
    element(box, "span", label);
  };
  figure(`${summary.placed} of ${summary.scans}`, "scans placed");
  figure(summary.components, summary.components === 1 ? "component" : "components");
  figure(summary.placed ? `${number(1e3 * summary.bundle_error_m, 1)} mm` : "none", "bundle error");
  if (summary.loops.worst.length) {
    figure(`${number(1e3 * summary.loops.median_misclosure_m, 1)} mm`, "median loop misclosure");
    figure(`${number(1e3 * summary.loops.largest_misclosure_m, 0)} mm`, "largest loop misclosure");
  } else figure("none", "loops: no global check");
  figure(summary.survey_band, "RICS band");
  figure(summary.links.used, "links used");
  figure(summary.links.rejected + summary.links.ambiguous, "rejected or ambiguous");
  figure(`${number(summary.time_s, 1)} s`, "time");
  if (summary.truth) {
    const { wrong, placed, median_translation_m: median } = summary.truth;
    figure(`${wrong} of ${placed}`, "placed scans wrong by the truth");
    if (wrong < placed) figure(`${number(1e3 * median, 1)} mm`, "median error of the others");
  }
  for (const note of summary.notes) element(byId("notes"), "p", note).className = "note";

  // Tables that sort by a click on a heading.
  const table = (id, columns, rows, empty, choose) => {
    const node = byId(id);
    node.replaceChildren();
    if (!rows.length) {
      element(element(node, "tr"), "td", empty);
      return;
    }
    const head = element(element(node, "thead"), "tr");
    const body = element(node, "tbody");
    const fill = () => {
      body.replaceChildren();
      for (const row of rows) {
        const line = element(body, "tr");
        if (choose) {
          line.className = "chooses";
          line.addEventListener("click", () => choose(row));
        }
        columns.forEach(([, value, digits]) => {
          const v = value(row);
          const cell = element(line, "td", typeof v === "number" ? number(v, digits || 0) : v);
          if (typeof v === "number") cell.className = "number";
        });
      }
    };
    columns.forEach(([name, value]) => {
      const cell = element(head, "th", name);
      if (rows.some((row) => typeof value(row) === "number")) cell.className = "number";
      cell.tabIndex = 0;
      const sort = () => {
        const ascending = cell.getAttribute("aria-sort") !== "ascending";
        head.querySelectorAll("th").forEach((other) => other.removeAttribute("aria-sort"));
        cell.setAttribute("aria-sort", ascending ? "ascending" : "descending");
        const rank = (v) => (v === null || v === undefined ? -Infinity : v);
        rows.sort((a, b) => {
          const x = rank(value(a));
          const y = rank(value(b));
          const order = x < y ? -1 : x > y ? 1 : 0;
          return ascending ? order : -order;
        });
        fill();
      };
      cell.addEventListener("click", sort);
      cell.addEventListener("keydown", (event) => event.key === "Enter" && sort());
    });
    fill();
  };
  const nameOf = (i) => scans[i].name;
  // Names of scans as the value of an option, for a shell.
  const scanArguments = (...names) => {
    const value = names.map((name) => (/[",]/.test(name) ? `"${name.replace(/"/g, '""')}"` : name)).join(",");
    return /[^\w.,/@%+=:-]/.test(value) ? `'${value.replace(/'/g, "'\\''")}'` : value;
  };
  const partnerOf = (link, i) => nameOf(link.source === i ? link.target : link.source);
  // Links that would join a scan to others than it stands with, the likeliest first.
  const linksOut = (i) =>
    links.filter((l) => (l.source === i || l.target === i) && scans[l.source].component !== scans[l.target].component)
      .sort((a, b) => (b.confidence || 0) - (a.confidence || 0));
  // Why a scan is not with most others: its own reason, or that of the link that comes nearest to joining it.
  const whyApart = (scan) => {
    if (scan.reason) return scan.reason;
    const i = scans.indexOf(scan);
    const [best] = linksOut(i);
    if (!best) return "no scan of another component shares enough with it";
    return `the best link to another component, to ${partnerOf(best, i)} (${number(best.confidence || 0, 2)})` +
           (best.reason ? `: ${best.reason}` : "");
  };
  // What a person can do about a scan that stands apart, from its reason and its best link.
  const help = (scan) => {
    const i = scans.indexOf(scan);
    if (!scan.usable) return "another copy of the file, or a new scan";
    if (scan.reason.startsWith("it holds the same points")) return "nothing: it is the same scan";
    const tried = linksOut(i);
    if (/storey/.test(scan.reason)) return "approximate --poses of its storey, or scans of the stairs";
    if (!tried.length) return "a scan that shows this place and a part of the others";
    const best = tried[0];
    const other = partnerOf(best, i);
    return `a scan between it and ${other} (their link: confidence ${number(best.confidence, 2)}, ` +
           `overlap ${number(100 * best.overlap, 0)} %), or --accept ${scanArguments(scan.name, other)} ` +
           "after a look at both";
  };
  table("unplaced", [["Scan", (s) => s.name], ["Component", (s) => s.component], ["Why", whyApart],
                     ["What would help", help]],
        scans.filter((s) => s.component !== 0 || !summary.placed), "All scans are in one component.");
  table("bridges", [["Source", (l) => nameOf(l.source)], ["Target", (l) => nameOf(l.target)],
                    ["Confidence", (l) => l.confidence, 3], ["Overlap %", (l) => 100 * l.overlap, 0]],
        links.filter((l) => l.bridge), "None: without any one link the map still holds together.", (l) => chooseLink(l));
  if (summary.control) {
    byId("control-section").hidden = false;
    table("control", [["Point", (c) => c.point], ["Residual [mm]", (c) => 1e3 * c.residual_m, 1],
                      ["x [mm]", (c) => 1e3 * c.dx_m, 1], ["y [mm]", (c) => 1e3 * c.dy_m, 1],
                      ["z [mm]", (c) => 1e3 * c.dz_m, 1]],
          summary.control.slice().sort((a, b) => b.residual_m - a.residual_m), "");
  }
  const setups = [["Scan", (s) => s.name], ["Component", (s) => s.component], ["Links", (s) => s.links],
                  ["σ position [mm]", (s) => (s.links ? s.sigma_mm : null), 1],
                  ["σ rotation [deg]", (s) => (s.links ? s.sigma_deg : null), 3]];
  if (summary.truth) setups.push(["Error [mm]", (s) => s.error_mm, 1]);
  setups.push(["Remark", (s) => s.reason]);
  table("setups", setups, scans.slice(), "", (s) => chooseScan(scans.indexOf(s)));
  const listLinks = () => {
    const wanted = byId("status").value;
    table("links", [["Source", (l) => nameOf(l.source)], ["Target", (l) => nameOf(l.target)], ["Status", (l) => l.status],
                    ["Confidence", (l) => l.confidence, 3], ["Overlap %", (l) => 100 * l.overlap, 0],
                    ["RMS [mm]", (l) => l.rmse_mm, 1], ["x %", (l) => 100 * l.strength[0], 0],
                    ["y %", (l) => 100 * l.strength[1], 0], ["z %", (l) => 100 * l.strength[2], 0],
                    ["< 6 mm %", (l) => 100 * l.below_6mm, 0], ["Residual [mm]", (l) => l.residual_mm, 1],
                    ["[deg]", (l) => l.residual_deg, 3], ["Why", (l) => l.reason]],
          links.filter((l) => !wanted || l.status === wanted).sort((a, b) => b.residual_mm - a.residual_mm),
          "None.", (l) => l.status === "used" && chooseLink(l));
  };
  byId("status").addEventListener("change", listLinks);
  listLinks();
  table("loops", [["Scans", (l) => l.scans.join(" – ")], ["Misclosure [mm]", (l) => 1e3 * l.translation_m, 1],
                  ["[deg]", (l) => l.rotation_deg, 3]], summary.loops.worst.slice(), "There are no loops.");

  // Drawings.
  const select = byId("component");
  summary.component_sizes.forEach((size, c) => {
    const option = element(select, "option", `${c} (${size} scan${size === 1 ? "" : "s"})`);
    option.value = c;
  });
  const tell = (text) => { byId("chosen").textContent = text; };
  const hint = byId("chosen").textContent;
  let only = null; // scans that are drawn when a link or a setup was clicked
  const show = (members, component, text) => {
    only = new Set(members);
    select.value = component;
    tell(`${text} Click the background for all scans.`);
    redraw();
    byId("plan").scrollIntoView({ block: "nearest" });
  };
  const chooseLink = (l) => {
    const a = scans[l.source], b = scans[l.target];
    show([l.source, l.target], a.component,
         `${a.name} – ${b.name}: overlap ${number(100 * l.overlap, 0)} %, RMS ${number(l.rmse_mm, 1)} mm, residual ` +
         `${number(l.residual_mm, 1)} mm, ${number(l.residual_deg, 3)} deg, below 6 mm ${number(100 * l.below_6mm, 0)} %, ` +
         `balance ${l.strength.map((v) => number(100 * v, 0)).join(" / ")} %, ` +
         `confidence ${number(l.confidence, 3)}${l.bridge ? ", a bridge" : ""}.`);
  };
  const chooseScan = (i) => {
    const s = scans[i];
    const near = links.filter((l) => l.status === "used" && (l.source === i || l.target === i))
      .map((l) => (l.source === i ? l.target : l.source));
    show([i, ...near], s.component,
         `${s.name}: ${s.links} link${s.links === 1 ? "" : "s"}, σ ${number(s.sigma_mm, 1)} mm, ${number(s.sigma_deg, 3)} deg` +
         `${near.length ? `; linked to ${near.map(nameOf).join(", ")}` : ""}.${s.reason ? ` ${s.reason}.` : ""}`);
  };
  const draw = (id, across, up) => {
    const svg = byId(id);
    svg.replaceChildren();
    const component = Number(select.value || 0);
    const members = scans.map((s, i) => [s, i]).filter(([s, i]) => s.component === component && (!only || only.has(i)));
    const xs = [], ys = [];
    for (const [s] of members) {
      xs.push(s.place[across]); ys.push(s.place[up]);
      for (let k = 0; k < s.points.length; k += 3) { xs.push(s.points[k + across]); ys.push(s.points[k + up]); }
    }
    if (!xs.length) return;
    // Far points must not make all else small: 1 % on each side is left out.
    const bounds = (v) => { v.sort((a, b) => a - b); const cut = Math.floor(v.length / 100); return [v[cut], v[v.length - 1 - cut]]; };
    const [x0, x1] = bounds(xs), [y0, y1] = bounds(ys);
    const size = Math.max(x1 - x0, y1 - y0, 1);
    const pad = 0.05 * size;
    svg.setAttribute("viewBox", `${x0 - pad} ${-y1 - pad} ${x1 - x0 + 2 * pad} ${y1 - y0 + 2 * pad}`);
    const dot = size / 250;
    const add = (name, attributes, title) => {
      const node = document.createElementNS(SVG, name);
      for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
      if (title) { const t = document.createElementNS(SVG, "title"); t.textContent = title; node.appendChild(t); }
      svg.appendChild(node);
      return node;
    };
    if (byId("show-points").checked)
      for (const [s, i] of members) {
        let path = "";
        for (let k = 0; k < s.points.length; k += 3) path += `M${s.points[k + across]} ${-s.points[k + up]}h0`;
        add("path", { d: path, stroke: hue(i), "stroke-width": dot, "stroke-linecap": "round", "stroke-opacity": 0.55, fill: "none" });
      }
    if (byId("show-links").checked)
      for (const l of links) {
        const a = scans[l.source], b = scans[l.target];
        if (l.status !== "used" || a.component !== component || (only && !(only.has(l.source) && only.has(l.target)))) continue;
        const ends = { x1: a.place[across], y1: -a.place[up], x2: b.place[across], y2: -b.place[up],
                       "vector-effect": "non-scaling-stroke" };
        add("line", { ...ends, class: `link ${grade(l.residual_mm)}`, stroke: "currentColor",
                      "stroke-dasharray": l.bridge ? "6 3" : "none" });
        // A wider one that is not seen, for fingers and mice.
        const hit = add("line", { ...ends, class: "hit", stroke: "transparent", "stroke-width": 12 }, `${a.name} – ${b.name}`);
        hit.addEventListener("click", () => chooseLink(l));
      }
    for (const [s, i] of members) {
      const circle = add("circle", { cx: s.place[across], cy: -s.place[up], r: 2.2 * dot, fill: hue(i), class: "setup",
                                     "stroke-width": dot / 2 }, s.name);
      circle.addEventListener("click", () => chooseScan(i));
    }
    // Names where they cover neither a setup nor each other.
    const taken = members.map(([s]) => [s.place[across] - 3 * dot, -s.place[up] - 3 * dot, 6 * dot, 6 * dot]);
    const letter = 4 * dot;
    for (const [s] of members) {
      const name = s.name.replace(/\.[^.#/]*$/, "");
      const width = 0.62 * letter * name.length;
      const places = [[4, 1.4], [4, -3], [4, 6], [-4, 1.4]].map(([x, y]) =>
        [s.place[across] + x * dot - (x < 0 ? width : 0), -s.place[up] + y * dot - letter, width, 1.2 * letter]);
      const free = places.find((p) => taken.every((q) => p[0] > q[0] + q[2] || q[0] > p[0] + p[2] ||
                                                         p[1] > q[1] + q[3] || q[1] > p[1] + p[3]));
      if (!free) continue;
      taken.push(free);
      add("text", { x: free[0], y: free[1] + letter, "font-size": letter, class: "name" }).textContent = name;
    }
    svg.onclick = (event) => { if (event.target === svg && only) { only = null; tell(hint); redraw(); } };
  };
  const redraw = () => { draw("plan", 0, 1); draw("side", 0, 2); };
  select.addEventListener("change", () => { only = null; tell(hint); redraw(); });
  byId("show-points").addEventListener("change", redraw);
  byId("show-links").addEventListener("change", redraw);
  redraw();
})();
