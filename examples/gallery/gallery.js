// Opens a panel large; arrow keys or 1 to 5 change to the other panels of its row at the same place.
const viewer = document.querySelector("dialog");
const large = viewer.querySelector("img");
const label = viewer.querySelector("p");
let row = [], at = 0;
function show(index) {
  at = (index + row.length) % row.length;
  large.src = row[at].src;
  large.alt = row[at].alt;
  label.textContent = `${at + 1}/${row.length}  ${row[at].alt}`;
}
for (const link of document.querySelectorAll(".row a")) {
  link.addEventListener("click", (event) => {
    event.preventDefault();
    row = [...link.closest(".row").querySelectorAll("img")];
    show(row.indexOf(link.querySelector("img")));
    viewer.showModal();
  });
}
viewer.addEventListener("click", () => viewer.close());
document.addEventListener("keydown", (event) => {
  if (!viewer.open) return;
  if (event.key === "ArrowRight") show(at + 1);
  else if (event.key === "ArrowLeft") show(at - 1);
  else if (event.key >= "1" && event.key <= String(row.length)) show(Number(event.key) - 1);
  else return;
  event.preventDefault();
});
