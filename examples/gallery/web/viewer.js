// The large view: two pictures at the same place, a line between them, one zoom for both.
const viewer = byId("viewer"), stage = byId("stage"), wipe = byId("wipe"), overlay = byId("overlay");
const ways = { left: byId("left-way"), right: byId("right-way") };
const panes = { left: byId("left-pane"), right: byId("right-pane") };
const MAX_ZOOM = 32;
const shown = { shot: null, view: "picture", left: null, right: null, wipe: 50, zoom: 1, x: 0, y: 0 };

const wayNamed = (name) => shown.shot.ways.find((way) => way.name === name) || null;
const titleOf = (way) => (way === null ? "ray-cast truth" : way.title);

function openViewer(shot, way) {
  shown.shot = shot;
  const drawn = shot.ways.filter((other) => !other.refused);
  if (drawn.length === 0) return;
  shown.left = way === null ? drawn[0] : way;
  shown.right = null;
  for (const select of Object.values(ways)) {
    select.replaceChildren(element("option", { value: "" }, "ray-cast truth"),
      ...drawn.map((other) => element("option", { value: other.name }, other.title)));
  }
  byId("viewer-title").replaceChildren(shot.scene.title, " ", element("small", {}, shot.caption));
  setView(state.view);
  setWipe(50);
  setZoom(1, 0, 0);
  viewer.showModal();
  wipe.focus();
}

// Chooses what the panes show. A side without such a picture shows another technique that has one.
function setView(wanted) {
  const drawn = shown.shot.ways.filter((way) => !way.refused);
  const view = drawn.some((way) => fileOf(shown.shot, way, wanted)) ? wanted : "picture";
  shown.view = view;
  if (!fileOf(shown.shot, shown.left, view)) shown.left = drawn[0];
  if (!fileOf(shown.shot, shown.right, view)) shown.right = drawn.find((way) => way !== shown.left) || drawn[0];
  for (const input of viewer.querySelectorAll("input[name=viewer-view]")) {
    input.checked = input.value === view;
    input.disabled = !drawn.some((way) => fileOf(shown.shot, way, input.value));
  }
  overlay.disabled = !drawn.some((way) => fileOf(shown.shot, way, "overlay"));
  stage.classList.toggle("exact", EXACT(view));
  drawPanes();
}

function drawPanes() {
  for (const side of ["left", "right"]) {
    const way = shown[side], pane = panes[side];
    const [base, errors] = pane.querySelectorAll("img");
    for (const option of ways[side].options) {
      option.disabled = !fileOf(shown.shot, option.value ? wayNamed(option.value) : null, shown.view);
    }
    ways[side].value = way === null ? "" : way.name;
    base.src = fileOf(shown.shot, way, shown.view);
    base.alt = `${shown.view} of ${titleOf(way)}`;
    const hasErrors = overlay.checked && way !== null && fileOf(shown.shot, way, "overlay");
    if (hasErrors) errors.src = fileOf(shown.shot, way, "overlay");
    errors.hidden = !hasErrors;
    byId(`${side}-tag`).textContent = titleOf(way);
  }
  byId("viewer-numbers").textContent = [shown.left, shown.right].filter((way) => way !== null).map(numbers).join("   ·   ");
  setWipe(shown.wipe);
}

function numbers(way) {
  const { error, cost } = way;
  if (!cost) return `${way.title}. ${way.caption}`;
  const wrong = error ? `${error.wrong} of ${error.judged} wrong, RMSE ${rmse(error.rmse)}` : "not judged";
  const soft = error && shown.shot.soft ? `, in the penumbra ${rmse(error.rmse_penumbra)}` : "";
  const notes = (way.notes || []).map((note) => ` ${note}`).join("");
  return `${way.title}: ${wrong}${soft}, cost ${times(cost.rest)} at rest, ${times(cost.moving)} moving.${notes}`;
}

function setWipe(percent) {
  shown.wipe = Math.min(100, Math.max(0, percent));
  stage.style.setProperty("--wipe", `${shown.wipe}%`);
  wipe.setAttribute("aria-valuenow", Math.round(shown.wipe));
  wipe.setAttribute("aria-valuetext", `${Math.round(shown.wipe)} % ${titleOf(shown.left)}, the rest ${titleOf(shown.right)}`);
}

// Zooms both panes, and keeps them within the stage.
function setZoom(zoom, x, y) {
  const { clientWidth: width, clientHeight: height } = stage;
  shown.zoom = Math.min(MAX_ZOOM, Math.max(1, zoom));
  shown.x = Math.min(0, Math.max(width * (1 - shown.zoom), x));
  shown.y = Math.min(0, Math.max(height * (1 - shown.zoom), y));
  stage.style.setProperty("--zoom", shown.zoom);
  stage.style.setProperty("--x", `${shown.x}px`);
  stage.style.setProperty("--y", `${shown.y}px`);
  stage.classList.toggle("zoomed", shown.zoom > 1);
  byId("zoom-value").textContent = `${shown.zoom.toFixed(shown.zoom < 10 ? 1 : 0)}×`;
}

// Zooms by a factor about a point of the stage; without one, about its middle.
function zoomBy(factor, at = { x: stage.clientWidth / 2, y: stage.clientHeight / 2 }) {
  const zoom = Math.min(MAX_ZOOM, Math.max(1, shown.zoom * factor));
  const part = zoom / shown.zoom;
  setZoom(zoom, at.x - (at.x - shown.x) * part, at.y - (at.y - shown.y) * part);
}

function placeOf(event) {
  const box = stage.getBoundingClientRect();
  return { x: event.clientX - box.left, y: event.clientY - box.top };
}

// One pointer moves the line, or the picture if it is zoomed and the pointer is off the line; two pointers zoom.
const pointers = new Map();
let drag = null;
stage.addEventListener("pointerdown", (event) => {
  if (event.button !== 0) return;
  stage.setPointerCapture(event.pointerId);
  const at = placeOf(event);
  pointers.set(event.pointerId, at);
  const isOnLine = event.target === wipe || Math.abs(at.x - (shown.wipe / 100) * stage.clientWidth) < 22;
  drag = shown.zoom === 1 || isOnLine ? "wipe" : "move";
  if (drag === "wipe") setWipe((100 * at.x) / stage.clientWidth);
  stage.classList.toggle("dragging", drag === "move");
  wipe.focus();
  event.preventDefault();
});
stage.addEventListener("pointermove", (event) => {
  const before = pointers.get(event.pointerId);
  if (!before) return;
  const at = placeOf(event);
  pointers.set(event.pointerId, at);
  if (pointers.size === 2) {
    const other = [...pointers].find(([id]) => id !== event.pointerId)[1];
    const spread = (place) => Math.hypot(place.x - other.x, place.y - other.y) || 1;
    zoomBy(spread(at) / spread(before), { x: (at.x + other.x) / 2, y: (at.y + other.y) / 2 });
  } else if (drag === "wipe") setWipe((100 * at.x) / stage.clientWidth);
  else if (drag === "move") setZoom(shown.zoom, shown.x + at.x - before.x, shown.y + at.y - before.y);
});
for (const name of ["pointerup", "pointercancel"]) {
  stage.addEventListener(name, (event) => {
    pointers.delete(event.pointerId);
    if (pointers.size === 0) drag = null;
    stage.classList.remove("dragging");
  });
}
stage.addEventListener("wheel", (event) => {
  event.preventDefault();
  zoomBy(Math.exp(-0.002 * event.deltaY), placeOf(event));
}, { passive: false });
stage.addEventListener("dblclick", (event) => (shown.zoom > 1 ? setZoom(1, 0, 0) : zoomBy(4, placeOf(event))));

// The technique before or after the left one, of those that were drawn.
function step(by) {
  const drawn = shown.shot.ways.filter((way) => !way.refused);
  shown.left = drawn[(drawn.indexOf(shown.left) + by + drawn.length) % drawn.length];
  drawPanes();
}

const pan = (x, y) => setZoom(shown.zoom, shown.x + (x * stage.clientWidth) / 8, shown.y + (y * stage.clientHeight) / 8);
const KEYS = {
  ArrowLeft: (event) => setWipe(shown.wipe - (event.shiftKey ? 10 : 2)),
  ArrowRight: (event) => setWipe(shown.wipe + (event.shiftKey ? 10 : 2)),
  Home: () => setWipe(0), End: () => setWipe(100),
  ArrowUp: () => step(-1), ArrowDown: () => step(1),
  "+": () => zoomBy(1.5), "=": () => zoomBy(1.5), "-": () => zoomBy(1 / 1.5), 0: () => setZoom(1, 0, 0),
  w: () => pan(0, 1), a: () => pan(1, 0), s: () => pan(0, -1), d: () => pan(-1, 0),
  e: () => { overlay.checked = !overlay.checked; drawPanes(); },
};
VIEWS.forEach(([view], index) => { KEYS[index + 1] = () => setView(view); });
viewer.addEventListener("keydown", (event) => {
  // Menus and radio buttons have keys of their own.
  if (event.ctrlKey || event.metaKey || event.altKey || event.target.matches("select, input[type=radio]")) return;
  const action = KEYS[event.key.length === 1 ? event.key.toLowerCase() : event.key];
  if (!action) return;
  action(event);
  event.preventDefault();
});

choice(byId("viewer-view"), "viewer-view", VIEWS, shown.view, setView);
for (const [side, select] of Object.entries(ways)) {
  select.addEventListener("change", () => { shown[side] = select.value ? wayNamed(select.value) : null; drawPanes(); });
}
overlay.addEventListener("change", drawPanes);
byId("zoom-in").addEventListener("click", () => zoomBy(1.5));
byId("zoom-out").addEventListener("click", () => zoomBy(1 / 1.5));
byId("viewer-close").addEventListener("click", () => viewer.close());
addEventListener("resize", () => setZoom(shown.zoom, shown.x, shown.y));
