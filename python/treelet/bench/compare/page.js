"use strict";
(() => {
  const data = JSON.parse(document.getElementById("data").textContent);
  const FEWEST = 1e6, MOST = 1e12, POINTS = 121;
  const TIMES = [0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100];
  const dark = matchMedia("(prefers-color-scheme: dark)");
  // Lighter twins of the colours, for a dark page.
  const ON_DARK = {
    "#1d1f26": "#ffffff", "#0067a8": "#5aaeea", "#e08a00": "#f0a830", "#009e73": "#30c59b",
    "#cc4c8a": "#ec8abb", "#56b4e9": "#9bd8ff", "#7a7f8c": "#b4b9c6", "#a5421f": "#e8845f",
    "#6b4fa0": "#b39ae6",
  };
  const state = {
    kind: data.main,
    scene: -1, // all scenes
    hidden: new Set(),
  };
  const byLabel = new Map(data.recipes.map((recipe, index) => [recipe.label, { ...recipe, index }]));
  const element = (id) => document.getElementById(id);
  const css = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  const colorOf = (recipe) => (dark.matches ? ON_DARK[recipe.color] || recipe.color : recipe.color);
  const isShown = (label) => !state.hidden.has(label);
  const escaped = (text) => text.replace(/&/g, "&amp;").replace(/</g, "&lt;");
  const kindName = () => data.kinds.find((kind) => kind.key === state.kind).name;

  const rayCounts = Array.from({ length: POINTS }, (_, index) => FEWEST * (MOST / FEWEST) ** (index / (POINTS - 1)));

  function rayText(rays) {
    for (const [limit, unit] of [[1e12, "T"], [1e9, "G"], [1e6, "M"]]) {
      const value = rays / limit;
      if (value >= 0.9995) return (value >= 9.95 ? value.toFixed(0) : value.toFixed(1).replace(/\.0$/, "")) + unit;
    }
    return String(Math.round(rays));
  }

  const effective = (rays, seconds, rate) => rays / (seconds + rays / rate);
  const geometricMean = (values) => {
    const found = values.filter((value) => value > 0);
    return found.length ? Math.exp(found.reduce((sum, value) => sum + Math.log(value), 0) / found.length) : null;
  };

  /** Effective rate over rayCounts by label, a share of the reference's ray rate, in %. */
  function payoffLines() {
    const curves = data.curves[state.kind];
    const chosen = state.scene < 0 ? curves.scenes : [curves.scenes[state.scene]];
    const scenes = chosen
      .map((scene) => new Map(scene.map(([label, seconds, rate]) => [label, { seconds, rate }])))
      .filter((scene) => scene.has(data.reference));
    const labels = state.scene < 0 ? curves.mean : scenes.flatMap((scene) => [...scene.keys()]);
    return labels.map((label) => ({
      label,
      values: rayCounts.map((rays) => {
        const shares = scenes.map((scene) => {
          const { seconds, rate } = scene.get(label);
          return effective(rays, seconds, rate) / scene.get(data.reference).rate;
        });
        return (100 * shares.reduce((sum, share) => sum + share, 0)) / shares.length;
      }),
    }));
  }

  function layout(more) {
    const axis = { gridcolor: css("--line"), zerolinecolor: css("--line"), linecolor: css("--quiet"), automargin: true };
    const { xaxis = {}, yaxis = {}, ...rest } = more;
    return {
      paper_bgcolor: css("--paper"), plot_bgcolor: css("--paper"),
      font: { color: css("--ink"), family: getComputedStyle(document.body).fontFamily, size: 13 },
      margin: { l: 56, r: 14, t: 30, b: 50 }, showlegend: false, hovermode: "closest",
      hoverlabel: { bgcolor: css("--band"), bordercolor: css("--line"), font: { color: css("--ink") } },
      xaxis: { ...axis, ...xaxis }, yaxis: { ...axis, ...yaxis }, ...rest,
    };
  }

  const draw = (id, traces, more) =>
    Plotly.react(id, traces, layout(more), { responsive: true, displaylogo: false, modeBarButtonsToRemove: ["lasso2d", "select2d", "sendChartToCloud"] });

  const pickedBest = () => {
    const best = data.best[state.kind];
    return state.scene < 0 ? best.mean : best.scenes[state.scene];
  };

  function drawPayoff() {
    const lines = payoffLines().filter((line) => isShown(line.label));
    const values = lines.flatMap((line) => line.values);
    const top = Math.max(1, ...values);
    const bottom = Math.max(0, 10 * Math.floor(Math.min(top, ...values) / 10) - 5);
    const band = top + 0.05 * (top - bottom);
    const traces = lines.map(({ label, values }) => {
      const recipe = byLabel.get(label);
      return {
        x: rayCounts, y: values, mode: "lines+markers", name: label,
        marker: { color: colorOf(recipe), symbol: recipe.marker, size: 8, maxdisplayed: 9 },
        line: { color: colorOf(recipe), dash: recipe.dash, width: label === data.reference ? 3 : 2 },
        hovertemplate: `${escaped(label)}<br>%{x:.2s} rays: %{y:.1f} %<extra></extra>`,
      };
    });
    const best = pickedBest();
    for (const [label, start, end] of best) {
      traces.push({
        x: [start, end], y: [band, band], mode: "lines", line: { color: colorOf(byLabel.get(label)), width: 8 },
        hovertemplate: `best from ${rayText(start)} to ${rayText(end)} rays: ${escaped(label)}<extra></extra>`,
      });
    }
    const ticks = [6, 7, 8, 9, 10, 11, 12].map((power) => 10 ** power);
    draw("payoff", traces, {
      height: 460,
      xaxis: { type: "log", range: [6, 12], tickvals: ticks, ticktext: ticks.map(rayText), title: { text: "rays traced with one tree" } },
      yaxis: { range: [bottom, band + 0.04 * (top - bottom)], title: { text: `effective rate, % of ${escaped(data.reference)}'s` } },
    });
    const words = best.map(([label, start, end]) => `${label} from ${rayText(start)} to ${rayText(end)}`);
    const { treeletMean, treeletScenes } = data.best[state.kind];
    const treelets = (state.scene < 0 ? treeletMean : treeletScenes[state.scene])
      .map(([, start, end]) => `${rayText(start)} to ${rayText(end)}`);
    element("payoff-note").textContent =
      "Rays over the time to build and to trace them. The bar on top is the best recipe's: " +
      `${words.join("; ") || "nothing measured"}. ` +
      (treelets.length ? `Recipes with treelets are best for ${treelets.join(" and ")} rays.` : "");
  }

  function drawCost() {
    const rows = state.scene < 0 ? data.scenes.map((_, index) => index) : [state.scene];
    const traces = data.recipes.filter((recipe) => isShown(recipe.label)).map((recipe) => {
      const { index } = byLabel.get(recipe.label);
      const build = geometricMean(rows.map((row) => data.buildShares[row][index]));
      const share = geometricMean(rows.map((row) => data.shares[state.kind][row][index]));
      return {
        x: [build], y: [share === null ? null : 100 * share], mode: "markers", name: recipe.label,
        marker: { color: colorOf(recipe), symbol: recipe.marker, size: 13, line: { color: css("--paper"), width: 1 } },
        hovertemplate: `${escaped(recipe.label)}<br>${escaped(recipe.recipe)}<br>build %{x:.3f} of the reference's<br>rays %{y:.1f} %<extra></extra>`,
      };
    });
    draw("cost", traces, {
      height: 420,
      xaxis: { type: "log", tickvals: TIMES, ticktext: TIMES.map(String), title: { text: `build time, × ${escaped(data.reference)}'s` } },
      yaxis: { title: { text: `${kindName()} rays, % of ${escaped(data.reference)}'s` } },
    });
  }

  function drawShares() {
    const names = data.scenes.map((scene) => scene.name);
    const traces = data.recipes
      .filter((recipe) => isShown(recipe.label) && recipe.label !== data.reference)
      .map((recipe) => {
        const { index } = byLabel.get(recipe.label);
        const shares = data.shares[state.kind].map((row) => (row[index] === null ? null : 100 * row[index]));
        return {
          x: shares, y: names, mode: "markers", name: recipe.label,
          marker: { color: colorOf(recipe), symbol: recipe.marker, size: 10, line: { color: css("--paper"), width: 1 } },
          hovertemplate: `${escaped(recipe.label)}<br>%{y}: %{x:.1f} %<extra></extra>`,
        };
      });
    draw("shares", traces, {
      height: 120 + 26 * names.length,
      xaxis: { title: { text: `${kindName()} rays, % of ${escaped(data.reference)}'s` } },
      yaxis: { autorange: "reversed", type: "category" },
      shapes: [{ type: "line", x0: 100, x1: 100, yref: "paper", y0: 0, y1: 1, line: { color: css("--ink"), width: 1.5 } }],
    });
  }

  function drawSizes() {
    element("size-section").hidden = data.sizes.length === 0;
    if (data.sizes.length === 0) return;
    const series = (points, name, color, dash) => ({
      x: points.map(([size]) => size), y: points.map(([, share]) => 100 * share), name,
      mode: "lines+markers", line: { color, dash, width: 2 }, marker: { size: 9 },
      hovertemplate: `${escaped(name)}<br>%{x} leaves: %{y:.1f} %<extra></extra>`,
    });
    const palette = data.recipes.map(colorOf);
    const traces = data.sizes.map((family, index) => series(family.points[state.kind], family.name, palette[(index + 1) % palette.length], "solid"));
    traces.push(series(data.talk, "talk, 2013: Soda Hall", css("--quiet"), "dash"));
    draw("sizes", traces, {
      height: 400, showlegend: true, legend: { orientation: "h", y: -0.25 },
      xaxis: { dtick: 1, title: { text: "treelet size, leaves" } },
      yaxis: { title: { text: `rays, % of ${escaped(data.reference)}'s` } },
    });
  }

  function drawAll() {
    drawPayoff();
    drawCost();
    drawShares();
    drawSizes();
  }

  const MARKERS = {
    circle: "M-5 0a5 5 0 1 0 10 0a5 5 0 1 0 -10 0", square: "M-4.5 -4.5h9v9h-9z", diamond: "M0 -6L6 0L0 6L-6 0z",
    "triangle-up": "M0 -5.5L6 5H-6z", "triangle-down": "M0 5.5L6 -5H-6z",
    "triangle-left": "M-5.5 0L5 -6V6z", "triangle-right": "M5.5 0L-5 -6V6z",
    cross: "M-2 -5.5h4v3.5h3.5v4h-3.5v3.5h-4v-3.5h-3.5v-4h3.5z",
    x: "M-5.5 -3L-3 -5.5L0 -2.5L3 -5.5L5.5 -3L2.5 0L5.5 3L3 5.5L0 2.5L-3 5.5L-5.5 3L-2.5 0z",
    pentagon: "M0 -5.8L5.5 -1.8L3.4 4.7H-3.4L-5.5 -1.8z",
  };
  const DASHES = { solid: "", dash: "5 2", dot: "1.5 2", dashdot: "6 2 1.5 2" };

  function drawRecipes() {
    const chips = data.recipes.map((recipe) => {
      const chip = document.createElement("button");
      chip.type = "button";
      chip.title = recipe.recipe;
      chip.setAttribute("aria-pressed", String(isShown(recipe.label)));
      chip.innerHTML =
        `<svg width="30" height="12" viewBox="0 -6 30 12" aria-hidden="true" fill="${colorOf(recipe)}">` +
        `<path d="M0 0H30" stroke="${colorOf(recipe)}" stroke-width="2.5" stroke-dasharray="${DASHES[recipe.dash]}"/>` +
        `<path transform="translate(15 0)" d="${MARKERS[recipe.marker]}"/></svg>`;
      chip.append(recipe.label);
      chip.addEventListener("click", () => {
        state.hidden.delete(recipe.label) || state.hidden.add(recipe.label);
        refresh();
      });
      return chip;
    });
    element("recipes").replaceChildren(...chips);
  }

  function refresh() {
    drawRecipes();
    drawAll();
  }

  function showOnly(labels) {
    state.hidden = new Set(data.recipes.map((recipe) => recipe.label).filter((label) => !labels.has(label)));
    refresh();
  }

  function fillSelect(id, options, chosen, change) {
    const select = element(id);
    select.replaceChildren(...options.map(([value, text]) => new Option(text, value, false, value === chosen)));
    select.addEventListener("change", () => {
      change(select.value);
      drawAll();
    });
  }

  function prepareControls() {
    fillSelect("kind", data.kinds.map((kind) => [kind.key, kind.name]), state.kind, (value) => (state.kind = value));
    const scenes = data.scenes.map((scene, index) => [String(index), `${scene.name}, ${scene.faces.toLocaleString("en")} triangles`]);
    fillSelect("scene", [["-1", "mean of all scenes"], ...scenes], "-1", (value) => (state.scene = Number(value)));
    element("all").addEventListener("click", () => showOnly(new Set(byLabel.keys())));
    element("none").addEventListener("click", () => showOnly(new Set([data.reference])));
    element("winners").addEventListener("click", () => showOnly(new Set([data.reference, ...pickedBest().map(([label]) => label)])));
  }

  /** Sort a table's body by a column: first the way that puts the best on top, then the other way round. */
  function sortBy(table, column) {
    const heading = table.tHead.rows[0].cells[column];
    const isText = heading.classList.contains("text");
    const first = isText ? "ascending" : "descending";
    const second = isText ? "descending" : "ascending";
    const order = heading.getAttribute("aria-sort") === first ? second : first;
    for (const other of table.tHead.rows[0].cells) other.removeAttribute("aria-sort");
    heading.setAttribute("aria-sort", order);
    const sign = order === "ascending" ? 1 : -1;
    const rows = [...table.tBodies[0].rows];
    rows.sort((left, right) => compareCells(left.cells[column], right.cells[column], isText, sign));
    table.tBodies[0].append(...rows);
  }

  function compareCells(left, right, isText, sign) {
    if (isText) return sign * left.textContent.localeCompare(right.textContent, "en", { numeric: true });
    const [first, second] = [left, right].map((cell) => (cell.dataset.value === undefined ? null : Number(cell.dataset.value)));
    if (first === null || second === null) return (first === null) - (second === null); // empty ones last
    return sign * (first - second);
  }

  for (const table of document.querySelectorAll("table")) {
    [...table.tHead.rows[0].cells].forEach((cell, column) =>
      cell.firstElementChild.addEventListener("click", () => sortBy(table, column)));
  }
  prepareControls();
  refresh();
  dark.addEventListener("change", refresh);
})();
