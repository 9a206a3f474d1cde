// The rows: the truth, and one card for each technique.
const state = { view: "picture", sort: "list" };
const cards = []; // what redraw() changes: { shot, way, image, button }
const rows = []; // { shot, list, items: [{ way, item }] }

function meter(kind, value, worst) {
  const part = worst > 0 && Number.isFinite(value) ? value / worst : 0;
  const bar = element("i", { style: `--part:${part.toFixed(4)}` });
  return element("span", { class: `meter ${kind}`, "aria-hidden": "true" }, bar);
}

function figure(name, text, bar) {
  return [element("dt", {}, name), element("dd", {}, bar, element("span", {}, text))];
}

function thumb(shot, way, title, text) {
  const image = element("img", { loading: "lazy", decoding: "async", alt: "", width: results.size[0], height: results.size[1] });
  const button = element("button", { type: "button", class: "thumb", "aria-label": `Open ${title}, ${text}` }, image);
  button.addEventListener("click", () => openViewer(shot, way));
  cards.push({ shot, way, image, button });
  return button;
}

function card(scene, shot, way, worst) {
  if (way.refused) {
    const why = element("div", { class: "thumb" }, element("p", {}, way.refused));
    return element("li", { class: "card refused" }, why, element("p", { class: "name" }, way.title));
  }
  if (!way.cost) {
    return element("li", { class: "card", "data-way": way.name }, thumb(shot, way, way.title, scene.title),
      element("p", { class: "name" }, way.title), element("p", { class: "caption" }, way.caption));
  }
  const error = errorOf(shot, way);
  const rest = costOf(way, "rest"), moving = costOf(way, "moving");
  const cost = `${times(rest)}, moving ${times(moving)}`;
  const unit = shot.soft ? "RMSE in the penumbra" : "wrong pixels";
  const text = `${scene.title}, ${shot.name}: ${error.text} ${unit}, cost ${cost}`;
  const numbers = element("dl", { class: "figures" },
    ...figure("error", error.text, meter("error", error.value, worst.error)),
    ...figure("at rest", times(rest), meter("cost", rest, worst.cost)),
    ...figure("moving", times(moving), meter("cost", moving, worst.cost)));
  return element("li", { class: "card", "data-way": way.name }, thumb(shot, way, way.title, text),
    element("p", { class: "name" }, way.title), numbers);
}

function truthCard(scene, shot) {
  const how = shot.soft ? `${results.samples} rays to the light at every pixel` : "one ray to each light at every pixel";
  return element("li", { class: "card truth" }, thumb(shot, null, "the ray-cast truth", `${scene.title}, ${shot.name}`),
    element("p", { class: "name" }, "Ray-cast truth"), element("p", { class: "caption" }, how));
}

function row(scene, shot) {
  const finite = (values) => Math.max(0, ...values.filter(Number.isFinite));
  const drawn = shot.ways.filter((way) => !way.refused);
  const worst = {
    error: finite(drawn.map((way) => errorOf(shot, way).value)),
    cost: finite(drawn.flatMap((way) => [costOf(way, "rest"), costOf(way, "moving")])),
  };
  shot.scene = scene;
  const list = element("ol", { class: shot.truth ? "row" : "row upright", "aria-label": `${scene.title}, ${shot.name}` },
    shot.truth ? truthCard(scene, shot) : null);
  const items = shot.ways.map((way) => ({ way, item: card(scene, shot, way, worst) }));
  list.append(...items.map(({ item }) => item));
  rows.push({ shot, list, items });
  const light = `Judged: ${shot.light}, ${shot.soft ? "a light with a size" : "a light without a size"}.`;
  return element("section", { class: "shot", "aria-label": shot.name },
    element("h3", {}, shot.caption), shot.truth ? element("p", { class: "caption" }, light) : null, list);
}

function buildScenes() {
  for (const scene of results.scenes) {
    const solid = scene.made_solid > 0
      ? element("p", { class: "quiet" }, "Visibility and error are of solid leaves; the pictures show them as they are.") : null;
    byId("scenes").append(element("section", { class: "scene", id: scene.name, "aria-labelledby": `${scene.name}-title` },
      element("h2", { id: `${scene.name}-title` }, scene.title), element("p", {}, scene.about), solid,
      ...scene.shots.map((shot) => row(scene, shot))));
    byId("index").append(element("a", { href: `#${scene.name}` }, scene.title));
  }
}

// Shows the chosen view in every thumbnail. What has no picture of it shows its picture or visibility.
function redraw() {
  for (const { shot, way, image, button } of cards) {
    const file = fileOf(shot, way, state.view) || fileOf(shot, way, "picture") || fileOf(shot, way, "visibility");
    if (image.getAttribute("src") !== file) image.src = file;
    button.classList.toggle("exact", EXACT(state.view));
  }
}

// Puts the cards of every row in order. Techniques that refuse the light come last.
function resort() {
  const key = {
    list: (shot, way, index) => index,
    error: (shot, way) => errorOf(shot, way).value,
    rest: (shot, way) => costOf(way, "rest"),
    moving: (shot, way) => costOf(way, "moving"),
  }[state.sort];
  for (const { shot, list, items } of rows) {
    const keyed = items.map((entry, index) => ({ ...entry, refused: Boolean(entry.way.refused), key: key(shot, entry.way, index) }));
    keyed.sort((a, b) => a.refused - b.refused || (a.key === b.key ? 0 : a.key - b.key));
    list.append(...keyed.map(({ item }) => item));
  }
}

buildScenes();
choice(byId("view"), "view", VIEWS, state.view, (view) => { state.view = view; redraw(); });
choice(byId("sort"), "sort", [["list", "List"], ["error", "Error"], ["rest", "Cost at rest"], ["moving", "Cost moving"]], state.sort,
  (sort) => { state.sort = sort; resort(); });
redraw();
