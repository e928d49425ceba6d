const box = document.getElementById("hover");
for (const mark of document.querySelectorAll(".mark")) {
  const twins = document.querySelectorAll(`[data-index="${mark.dataset.index}"]`);
  mark.addEventListener("mousemove", (event) => {
    box.textContent = mark.dataset.text; box.style.display = "block";
    box.style.left = `${Math.min(event.clientX + 14, innerWidth - box.offsetWidth - 8)}px`;
    box.style.top = `${Math.min(event.clientY + 14, innerHeight - box.offsetHeight - 8)}px`;
    twins.forEach((twin) => twin.classList.add("lit"));
  });
  mark.addEventListener("mouseleave", () => {
    box.style.display = "none"; twins.forEach((twin) => twin.classList.remove("lit"));
  });
}
