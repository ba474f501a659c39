mod drive;
mod drives;
mod groups;
mod presents;
mod random;
mod sizes;
mod steps;
